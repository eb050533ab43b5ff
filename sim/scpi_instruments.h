// SPDX-License-Identifier: Apache-2.0
// What Thorlabs' LED driver DC2200 and power meters do when told, without the cable.

#pragma once

#include <deque>
#include <functional>
#include <mutex>
#include <string>
#include <string_view>

namespace gonio {

// The queue of errors that all such instruments have (SYST:ERR?, *CLS).
class ScpiErrors {
 public:
  void Note(int code, const std::string& text);
  std::string Next();  // "0,\"No error\"" if there is none
  void Clear() { errors_.clear(); }

 private:
  std::deque<std::string> errors_;
};

// An LED at constant current; its power is proportional to that. Any thread.
class Dc2200Emulator {
 public:
  explicit Dc2200Emulator(double limit = 1.0) : limit_(limit) {}  // A

  // The answer to a line, empty for commands; what it does not know it notes as an error.
  std::string Receive(std::string_view line);

  double Current() const;           // A, through the LED
  void TurnByHand(double current);  // A, on the front panel; 0 switches off
  void RemoveLed();                 // no current whatever is set

 private:
  std::string Command(const std::string& name, const std::string& argument);
  std::string Query(const std::string& name);
  double Flowing() const { return on_ && led_ ? current_ : 0; }

  mutable std::mutex mutex_;
  const double limit_;
  std::string mode_ = "CB";  // as somebody else left it
  double current_ = 0;
  bool on_ = true;  // the same
  bool led_ = true;
  ScpiErrors errors_;
};

// A PM100D, or another of its family, with a photodiode. Any thread.
class PowerMeterEmulator {
 public:
  struct Settings {
    std::string identity = "Thorlabs,PM100D,P0012345,2.4.0";
    std::string sensor = "\"S120C\",\"16060232\",\"2-JUN-2021\",1,18,33";
    bool says_when_ready = false;  // has FETC:STAT?
  };

  // `power`: W that fall on the sensor now.
  explicit PowerMeterEmulator(std::function<double()> power);
  PowerMeterEmulator(std::function<double()> power, Settings settings);

  std::string Receive(std::string_view line);

  // Settings as they are now.
  double wavelength_nm() const;
  int averaging() const;
  bool automatic() const;
  double range() const;  // W
  // Values it cannot have are taken for the nearest it can, without a word.
  void set_rounds_wavelength_to(double step_nm);
  void ReadNext(const std::string& answer);  // of FETC?, instead of the power

 private:
  std::string Command(const std::string& name, const std::string& argument);
  std::string Query(const std::string& name, const std::string& argument);
  std::string Fetch();

  mutable std::mutex mutex_;
  const std::function<double()> power_;
  const Settings settings_;
  double wavelength_ = 635;  // nm; all as somebody else left it
  double wavelength_step_ = 1e-3;
  int averaging_ = 10;
  bool automatic_ = true;
  double range_ = 0.05;  // W
  bool watt_ = false;
  bool measures_power_ = false;
  double reading_ = 0;   // of the last INIT
  int until_ready_ = 0;  // questions whether it is
  std::string next_;
  ScpiErrors errors_;
};

}  // namespace gonio
