// SPDX-License-Identifier: Apache-2.0
#include "acquisition/session_state.h"

namespace gonio {
namespace {

struct Transition {
  SessionState from;
  SessionSignal signal;
  SessionState to;
};

using enum SessionState;
using enum SessionSignal;

constexpr Transition kTransitions[] = {
    {kUnhomed, kHomed, kIdle},
    {kIdle, kStart, kRunning},
    {kRunning, kPoseDone, kRunning},
    {kRunning, kPause, kPausing},
    {kPausing, kPoseDone, kPaused},
    {kPaused, kGoOn, kRunning},
    {kRunning, kTrip, kSuspended},
    {kDisconnected, kTrip, kSuspended},
    {kSuspended, kClear, kRunning},
    {kRunning, kLost, kDisconnected},
    {kDisconnected, kLost, kDisconnected},  // once more
    {kDisconnected, kOpened, kRunning},
    {kRunning, kCall, kPaused},
    {kDisconnected, kCall, kPaused},
    {kStopping, kCleanedUp, kEnded},
    {kFault, kCleanedUp, kFault},  // a fault is left by a new session only
    {kEmergencyStop, kCleanedUp, kEmergencyStop},
    {kStopping, kFail, kFault},
    {kFault, kFail, kFault},
    {kEmergencyStop, kFail, kEmergencyStop},
};

// What can happen at any time, until it is over.
std::optional<SessionState> AtAnyTime(SessionState state, SessionSignal signal) {
  if (state == kStopping || state == kEnded || state == kFault || state == kEmergencyStop) {
    return std::nullopt;
  }
  if (signal == kStop || signal == kAbort) return kStopping;
  if (signal == kFail) return kFault;
  if (signal == kEmergency) return kEmergencyStop;
  return std::nullopt;
}

}  // namespace

std::optional<SessionState> After(SessionState state, SessionSignal signal) {
  for (const Transition& transition : kTransitions) {
    if (transition.from == state && transition.signal == signal) return transition.to;
  }
  return AtAnyTime(state, signal);
}

const char* ToString(SessionState state) {
  switch (state) {
    case kDisconnected:
      return "disconnected";
    case kUnhomed:
      return "unhomed";
    case kIdle:
      return "idle";
    case kRunning:
      return "running";
    case kPausing:
      return "pausing";
    case kPaused:
      return "paused";
    case kSuspended:
      return "suspended";
    case kStopping:
      return "stopping";
    case kEnded:
      return "ended";
    case kFault:
      return "fault";
    case kEmergencyStop:
      return "emergency stop";
  }
  return "unknown";
}

}  // namespace gonio
