// SPDX-License-Identifier: Apache-2.0
// The protocol of Newport's ESP301 and ESP300 controllers, as text.

#pragma once

#include <string>
#include <string_view>

#include "core/error.h"

namespace gonio::esp301 {

// "2PA12.5\r", or with axis 0 what is the controller's own, "TE?\r".
std::string Encode(int axis, std::string_view command);

// Answers are bare values, so an answer to another question shows only if it has another form:
// every decoder takes nothing but its own, blanks around it left out. All errors are kProtocol.

// Lines that it sends unasked begin with E and a number.
bool IsUnasked(std::string_view line);

// The answer to VE?, which no other answer can be taken for: "ESP301 Version 3.0.1 6/1/99".
bool IsVersion(std::string_view line);

// "0" or "1"; `what` is the question.
Result<bool> FlagIn(std::string_view answer, std::string_view what);
// "-12.5", finite.
Result<double> ValueIn(std::string_view answer, std::string_view what);

// The answer to SN?: what positions are counted in.
inline constexpr int kDegrees = 7;
Result<int> UnitIn(std::string_view answer);
std::string TextOfUnit(int unit);

// From the error queue.
struct QueuedError {
  int axis = 0;    // 0: of the controller
  int number = 0;  // 0: the queue is empty

  bool none() const { return axis == 0 && number == 0; }
  bool operator==(const QueuedError&) const = default;
};
// The answer to TE?, "106".
Result<QueuedError> ErrorIn(std::string_view answer);
// In words: "positive software limit".
inline constexpr const char* kEmergencyStop = "emergency stop";
std::string TextOf(const QueuedError& error);
// Whether it happened to the axis, or to all if error.axis is 0, rather than refuse a command. One
// that is not known is taken for a fault.
bool IsFault(const QueuedError& error);

}  // namespace gonio::esp301
