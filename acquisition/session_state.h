// SPDX-License-Identifier: Apache-2.0
// What a session is doing, as a state machine. docs/sessions.md draws it.

#pragma once

#include <optional>

namespace gonio {

enum class SessionState {
  kDisconnected,   // a device is opened anew, for as long as its failure policy has it
  kUnhomed,        // devices are open, where the axes are is not known
  kIdle,           // homed, light on
  kRunning,        // poses are measured
  kPausing,        // a pause was asked for; the pose is finished first
  kPaused,         // nothing moves, everything is kept as it is
  kSuspended,      // the same, until an interlock is clear
  kStopping,       // the end: a stop was asked for, the plan is done, or clean-up after a fault
  kEnded,          // light off; the devices may be closed
  kFault,          // a device failed, or the log, or clean-up; arms have been told to stop
  kEmergencyStop,  // somebody pressed one; nothing moves until a person has released it
};

enum class SessionSignal {
  kHomed,
  kStart,
  kPause,     // by the user
  kPoseDone,  // measured or refused
  kGoOn,      // by the user
  kTrip,      // an interlock is not met
  kClear,     // all are
  kLost,      // a device failed and is to be opened anew
  kOpened,    // it was, axes homed if need be
  kCall,      // a person is needed
  kStop,      // by the user, or nothing is left to measure
  kAbort,     // by the user: arms stop at once
  kFail,
  kEmergency,
  kCleanedUp,  // light off, arms still
};

inline constexpr SessionState kSessionStates[] = {
    SessionState::kDisconnected, SessionState::kUnhomed,      SessionState::kIdle,
    SessionState::kRunning,      SessionState::kPausing,      SessionState::kPaused,
    SessionState::kSuspended,    SessionState::kStopping,     SessionState::kEnded,
    SessionState::kFault,        SessionState::kEmergencyStop};
inline constexpr SessionSignal kSessionSignals[] = {
    SessionSignal::kHomed,    SessionSignal::kStart,     SessionSignal::kPause,
    SessionSignal::kPoseDone, SessionSignal::kGoOn,      SessionSignal::kTrip,
    SessionSignal::kClear,    SessionSignal::kLost,      SessionSignal::kOpened,
    SessionSignal::kCall,     SessionSignal::kStop,      SessionSignal::kAbort,
    SessionSignal::kFail,     SessionSignal::kEmergency, SessionSignal::kCleanedUp};

// Empty: the signal means nothing in that state.
std::optional<SessionState> After(SessionState state, SessionSignal signal);

// "unhomed", "running", ...
const char* ToString(SessionState state);

}  // namespace gonio
