// SPDX-License-Identifier: Apache-2.0
// The controllers that speak GCS 2 on one serial line.

#pragma once

#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "drivers/fault_book.h"
#include "drivers/line_reader.h"

namespace gonio::gcs2 {

// The controller, or the daisy chain of them, on one serial line (115200 baud; E-861: 38400). Any
// thread, one exchange at a time. Addresses are those of Encode() in drivers/gcs2_codec.h.
//
// Replies name the axis but not the question. So what has come in is discarded before each
// question, and after a reply that was late or made no sense the controller is first asked for its
// identity, which nothing else looks like: what comes before that belongs to questions that were
// given up. What cannot be noticed is a digit that turned into another on the line.
class Line {
 public:
  static constexpr Seconds kReplyLimit{1};

  explicit Line(std::unique_ptr<ByteLink> link, Seconds reply_limit = kReplyLimit);

  // Questions are asked again if their reply does not come or makes no sense. kRefused: the
  // controller passed the question over, and says why.
  Result<std::string> Identity(int address);
  Result<double> Syntax(int address);
  Result<std::vector<std::string>> Axes(int address);
  Result<std::string> Unit(int address, const std::string& axis);
  Result<bool> IsReady(int address);
  Result<unsigned> Moving(int address);  // bit 0 is the first of Axes()
  // "POS?" and the like.
  Result<double> Number(int address, const std::string& question, const std::string& axis);
  Result<bool> Flag(int address, const std::string& question, const std::string& axis);

  // A command answers nothing, so the error is read before and after it. kRefused: it says why not.
  Result<void> Command(int address, const std::string& command);
  // HLT for one axis, or, if the controller does not know that, as hard as it can for all. Sent
  // before anything is asked, and never kRefused.
  Result<void> Halt(int address, const std::string& axis);
  Result<void> StopAll(int address);

  // Takes the error away; faults are kept, for each axis until it has been homed again.
  Result<void> ReadErrors(int address);
  int faults() const;  // so many have been noted
  std::string FaultAfter(int faults, int address) const;

 private:
  using Reply = Result<std::vector<std::string>>;  // its lines, one at least
  template <typename Decode>
  auto Ask(int address, const std::string& question, Decode decode)
      -> decltype(decode(std::vector<std::string>()));
  // Of a reply of one line.
  template <typename Decode>
  auto AskLine(int address, const std::string& question, Decode decode)
      -> decltype(decode(std::string_view()));
  Reply Exchange(int address, const std::string& question);
  Reply ReadReply(int address);
  Result<void> GetInStep(int address);
  Result<void> SendStopAll(int address);
  Result<int> TakeError(int address);
  Error Refused(int address, const std::string& what, int error) const;
  Error About(int address, const std::string& question, const Error& error) const;

  mutable std::mutex mutex_;
  std::unique_ptr<ByteLink> link_;
  LineReader lines_;
  Seconds reply_limit_;
  bool in_step_ = true;  // the next reply will be that to the next question
  FaultBook faults_;
};

}  // namespace gonio::gcs2
