// SPDX-License-Identifier: Apache-2.0
// What went over the wires.

#pragma once

#include <cstddef>
#include <deque>
#include <filesystem>
#include <fstream>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <string_view>

#include "core/clock.h"
#include "drivers/byte_link.h"
#include "drivers/message_link.h"

namespace gonio {

// Keeps the last lines for an error report and, once it has a file, all of them:
//
//     12.345678 /dev/ttyUSB0 > "/1 1 03 get pos:8A\x0a"
//     12.347012 /dev/ttyUSB0 < "@01 1 03 OK IDLE -- 12000:6E\x0d\x0a"
//
// time [s] on `clock`; > sent, < received, as the bytes came. Any thread.
class LinkLog {
 public:
  static constexpr std::size_t kKept = 1000;  // lines; an opening rig needs a few hundred

  struct Count {
    long sent = 0;  // messages handed to the link
    long bytes_sent = 0;
    long bytes_received = 0;
    long failures = 0;  // calls that ended with an error
  };

  // `clock` outlives it.
  explicit LinkLog(const Clock* clock) : clock_(clock) {}

  void Sent(const std::string& link, std::string_view bytes);
  void Received(const std::string& link, std::string_view bytes);
  void Failed(const std::string& link, const std::string& why);

  // The lines kept so far and those to come go there, each as it comes. A log that cannot be
  // written is no reason to end a measurement: what is missing then is missing.
  void WriteTo(const std::filesystem::path& file);
  // The last so many lines, oldest first, one below the other.
  std::string Last(std::size_t lines) const;
  std::map<std::string, Count> Counts() const;  // by link

 private:
  void Add(const std::string& link, const char* way, const std::string& what);

  const Clock* const clock_;
  mutable std::mutex mutex_;
  std::deque<std::string> lines_;
  std::ofstream file_;
  std::map<std::string, Count> counts_;
};

// `link`, every call of which is noted in `log`.
std::unique_ptr<ByteLink> Logged(std::unique_ptr<ByteLink> link, std::shared_ptr<LinkLog> log);
std::unique_ptr<MessageLink> Logged(std::unique_ptr<MessageLink> link,
                                    std::shared_ptr<LinkLog> log);

}  // namespace gonio
