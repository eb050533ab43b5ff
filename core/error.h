// SPDX-License-Identifier: Apache-2.0
// The errors of Goniopilot and the channel each travels on.
//
//   our own bug                       GONIO_CHECK (core/check.h), aborts
//   bad configuration, file, option   ConfigError, thrown while starting up or opening
//   the world refused                 Error inside a Result<T>
//   the numbers did not work out      fields of a summary, never an error

#pragma once

#include <stdexcept>
#include <string>
#include <utility>
#include <variant>

#include "core/check.h"

namespace gonio {

// What a user wrote is wrong. what() is one line: "configs/rig.yaml:14: axes.x.max_deg: must be
// ...".
class ConfigError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

// Chosen by what the caller does next.
enum class ErrorCode {
  kTimeout,        // no answer in time; worth a retry
  kDisconnected,   // the link is gone; open the device again
  kProtocol,       // the answer made no sense; stop and look at the log
  kRefused,        // the request broke a promise; fix the caller, or skip the pose
  kCancelled,      // the user asked to stop; the device is at rest
  kStorage,        // the disk refused; nothing more can be kept, so end the session
  kEmergencyStop,  // an emergency stop is pressed; nothing moves until a person has released it
};

// "timeout", "disconnected", ...: as written in the event log.
const char* ToString(ErrorCode code);

struct Error {
  ErrorCode code;
  std::string message;  // device or file, operation, what happened; one line, no full stop
};

// A value or the reason why there is none.
template <typename T>
class [[nodiscard]] Result {
 public:
  Result(T value) : state_(std::move(value)) {}      // NOLINT: implicit on purpose
  Result(Error error) : state_(std::move(error)) {}  // NOLINT

  bool ok() const { return std::holds_alternative<T>(state_); }
  explicit operator bool() const { return ok(); }

  // Precondition: ok().
  const T& value() const& { return Checked(), std::get<T>(state_); }
  T& value() & { return Checked(), std::get<T>(state_); }
  T&& value() && { return Checked(), std::get<T>(std::move(state_)); }
  const T& operator*() const& { return value(); }
  T& operator*() & { return value(); }
  const T* operator->() const { return &value(); }
  T* operator->() { return &value(); }

  // Precondition: !ok().
  const Error& error() const {
    GONIO_CHECK(!ok(), "error() of a Result that holds a value");
    return std::get<Error>(state_);
  }

 private:
  void Checked() const { GONIO_CHECK(ok(), ok() ? "" : std::get<Error>(state_).message); }

  std::variant<T, Error> state_;
};

template <>
class [[nodiscard]] Result<void> {
 public:
  Result() = default;
  Result(Error error) : state_(std::move(error)) {}  // NOLINT: implicit on purpose

  bool ok() const { return std::holds_alternative<std::monostate>(state_); }
  explicit operator bool() const { return ok(); }
  const Error& error() const {
    GONIO_CHECK(!ok(), "error() of a Result without one");
    return std::get<Error>(state_);
  }

 private:
  std::variant<std::monostate, Error> state_;
};

}  // namespace gonio
