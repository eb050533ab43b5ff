// SPDX-License-Identifier: Apache-2.0
// Instruments that are told what to do in lines of text, as IEEE 488.2 and SCPI have it.

#pragma once

#include <memory>
#include <mutex>
#include <string>
#include <utility>

#include "drivers/message_link.h"

namespace gonio::scpi {

// Answers carry no number, so one that comes too late could be taken for that to the next question.
// Therefore, at opening and after every exchange that went wrong, the device is cleared and asked
// who it is, and whatever comes before that answer is thrown away.
//
// Any thread, one exchange at a time. Messages of errors begin with name().
class Instrument {
 public:
  static constexpr Seconds kReplyLimit{3};

  // kProtocol: what answers is not an instrument of this kind.
  static Result<std::unique_ptr<Instrument>> Open(std::unique_ptr<MessageLink> link,
                                                  Seconds reply_limit = kReplyLimit);

  const std::string& name() const { return link_->name(); }
  // The answer to *IDN?: maker, model, serial number, firmware, separated by commas.
  const std::string& identity() const { return identity_; }

  // The answer without its line end. Asked again if it does not come or makes no sense.
  Result<std::string> Query(const std::string& question);
  Result<double> Number(const std::string& question);
  // Asked once, for what takes longer than other answers.
  Result<double> Number(const std::string& question, Seconds limit);
  // kRefused: the device noted errors (SYST:ERR?) after it; the message has their texts. Sent once:
  // after other errors nobody knows whether it was heard.
  Result<void> Command(const std::string& command);

 private:
  Instrument(std::unique_ptr<MessageLink> link, Seconds reply_limit)
      : link_(std::move(link)), reply_limit_(reply_limit) {}

  Result<void> FallIn();  // in step: no answer is owed
  Result<std::string> Exchange(const std::string& question, Seconds limit);
  Result<double> NumberOf(const std::string& question, Seconds limit);
  Result<std::string> Errors();
  Error OutOfStep(const Error& error, const std::string& what);

  std::mutex mutex_;
  const std::unique_ptr<MessageLink> link_;
  const Seconds reply_limit_;
  std::string identity_;
  bool in_step_ = false;
};

}  // namespace gonio::scpi
