// SPDX-License-Identifier: Apache-2.0
// The APT controller, or the rack of them, at one serial port.

#pragma once

#include <map>
#include <memory>
#include <mutex>
#include <set>
#include <string>

#include "drivers/apt_codec.h"
#include "drivers/byte_link.h"

namespace gonio::apt {

// Asks one question at a time, for all the motors at its port. Controllers speak unasked, too: of
// moves that end, of errors, and of how they are if another program has told them to. So the answer
// to a question is the message of the right kind from the right module about the right motor;
// errors are kept, and all else is passed over. Any thread.
//
// Messages have no checksum. After one that makes no sense all is thrown away that comes until the
// line is quiet. Questions carry no number: of two that are the same the first's answer, if it
// comes late, is taken for the second's, so it may be older than it by the reply limit.
class Link {
 public:
  static constexpr Seconds kReplyLimit{1};

  explicit Link(std::unique_ptr<ByteLink> link, Seconds reply_limit = kReplyLimit);

  // The answer, of kind `answer`. Asked again if it does not come or makes no sense. kRefused: the
  // controller reports an error about the question.
  Result<Message> Query(const Message& question, Id answer);
  // Commands are not answered, so a question (REQ_STATUSBITS) follows, whose answer shows that the
  // command was read. Sent once: after kTimeout or kProtocol nobody knows whether it was. kRefused:
  // the controller reports an error meanwhile.
  Result<void> Command(const Message& command, const Address& motor);
  // Sends what nobody confirms.
  Result<void> Tell(const Message& message);

  // The last error that a module has reported out of turn, until it is forgotten; empty: none.
  std::string ReportOf(int module);
  // Whether it has said since then that a motor has been homed (MOVE_HOMED).
  bool HasHomed(const Address& motor);
  void Forget(int module);

 private:
  // The answer to `question`, which is sent behind `command` if there is one.
  Result<Message> Exchange(const Message* command, const Message& question, Id answer);
  Result<Message> Next(Seconds left);
  // Looks at what has come unasked since the last question.
  Result<void> CatchUp();
  void Note(const Message& message);
  void Resynchronise();
  Error About(const Message& message, const Error& error) const;

  std::mutex mutex_;
  std::unique_ptr<ByteLink> link_;
  Seconds reply_limit_;
  std::string pending_;                  // what has come of a message that is not complete
  std::map<int, std::string> reports_;   // by module
  std::set<std::pair<int, int>> homed_;  // modules and channels
};

}  // namespace gonio::apt
