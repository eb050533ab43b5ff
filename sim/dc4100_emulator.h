// SPDX-License-Identifier: Apache-2.0
// A Thorlabs DC4100 with four LEDs, as its serial line sees it.

#pragma once

#include <array>
#include <mutex>
#include <string>
#include <string_view>

namespace gonio {

// As much of it as a driver needs; written from the published command set and not from our driver.
// Commands answer nothing; what was wrong with the last one is asked for (e?). Any thread.
class Dc4100Emulator {
 public:
  static constexpr int kChannels = 4;

  // Bytes from the line; what is answered to the queries they complete.
  std::string Receive(std::string_view bytes);

  double Current(int channel) const;               // A, through the LED
  void TurnByHand(int channel, int milliamperes);  // at the knob; 0 switches off
  // It is neither switched on nor off from now on, and no error is noted.
  void set_stuck(int channel);

 private:
  struct Channel {
    bool on = true;  // as somebody else left it
    bool stuck = false;
    int milliamperes = 30;
    int user_limit = 800;
    int most = 1000;
  };

  std::string Obey(const std::string& line);
  std::string Answer(const std::string& question, int channel);
  void Set(const std::string& name, int channel, const std::string& argument);
  void Fail(int code, const char* text);

  mutable std::mutex mutex_;
  std::array<Channel, kChannels> channels_;
  int mode_ = 1;
  std::string pending_;
  std::string error_ = "ERROR 0:No error";
};

}  // namespace gonio
