// SPDX-License-Identifier: Apache-2.0
// The serial line to one Grbl.

#pragma once

#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "drivers/byte_link.h"
#include "drivers/grbl_codec.h"
#include "drivers/line_reader.h"

namespace gonio::grbl {

class Line;

// What follows from all that a Grbl has said, asked or not.
class Condition {
 public:
  // It has looked for its switches, and nothing has been said since that could have cost it its
  // position: no welcome, no alarm, no sleep.
  bool homed() const { return homed_; }
  // Between "$H" and its "ok", while it answers nothing and takes nothing but a reset.
  bool homing() const { return homing_; }
  // After a limit alarm, the same.
  bool blocked() const { return blocked_; }
  // The last alarm in words, until it was homed, or reset by us; empty: none.
  const std::string& fault() const { return fault_; }
  unsigned homings() const { return homings_; }  // that ended well

 private:
  friend class Line;
  bool homed_ = false;
  bool homing_ = false;
  bool blocked_ = false;
  std::string fault_;
  unsigned homings_ = 0;
};

// One line at a time is sent, and the next one after its "ok". Alarms, welcomes, and messages that
// come in between are noted in condition(). One thread at a time.
//
// Errors name the line: kRefused is an "error:" in words.
class Line {
 public:
  Line(std::unique_ptr<ByteLink> link, Seconds reply_limit);

  const std::string& name() const { return link_->name(); }
  const Condition& condition() const { return condition_; }

  // Until it says that it was reset. kTimeout: it does not.
  Result<void> AwaitWelcome(Seconds limit);
  // Takes in what has come unasked, waiting so long for it. Lines that make no sense are passed
  // over: a bootloader's, say.
  Result<void> Hear(Seconds limit);
  // State and position, in the machine's coordinates; asked twice. The last one known while it does
  // not answer: homing or blocked. A report that comes too late, after it was asked for again, may
  // be taken for the second one's.
  Result<Report> AskStatus();
  // What was said before the "ok". Sent once; not while homing() or blocked().
  Result<std::vector<Message>> Tell(const std::string& line);
  // Bytes that are not answered.
  Result<void> Send(char byte);
  // Until it has come back. It has no position then.
  Result<void> Reset();
  // Says "$H" and does not wait for its "ok", which condition() knows of once it was heard.
  Result<void> StartHoming();

 private:
  Result<Message> Next(Seconds limit);
  Result<Report> AskOnce();
  // After an answer that was missed: until nothing is owed any more.
  Result<void> CatchUp();
  void Take(Message* message);
  void TakeReport(Report* report);

  std::unique_ptr<ByteLink> link_;
  LineReader lines_;
  Seconds reply_limit_;
  Condition condition_;
  Report last_;
  std::vector<double> offset_;  // of work positions; empty: not known
  bool owes_ = false;           // an answer that was missed may still come
};

}  // namespace gonio::grbl
