// SPDX-License-Identifier: Apache-2.0
// The protocol of Newport's SMC100 and CONEX controllers, as text.

#pragma once

#include <string>
#include <string_view>

#include "core/error.h"

namespace gonio::smc100 {

// "1PA12.5\r\n". Address 1 .. 31.
std::string Encode(int address, std::string_view command);

// What follows address and command in the answer to a query: "-0.123" of "1TP-0.123". kProtocol: it
// answers something else.
Result<std::string> AnswerTo(int address, std::string_view command, std::string_view line);

// Of an axis, from the two last digits of the answer to TS.
enum class State {
  kNotReferenced,
  kConfiguration,
  kHoming,
  kMoving,
  kReady,
  kDisabled,
  kJogging,
};

struct Status {
  unsigned errors = 0;  // of the positioner, one bit each
  State state = State::kNotReferenced;
};
// The answer to TS, "000032" as AnswerTo() gives it.
Result<Status> DecodeStatus(std::string_view answer);

// The errors in words: "following error, homing time-out"; empty: none.
std::string TextOf(unsigned errors);

// The answer to TE, a letter, in words; empty for "@": nothing went wrong.
std::string TextOfCommandError(char letter);

}  // namespace gonio::smc100
