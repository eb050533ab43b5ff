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
    {kUnhomed, kFail, kFault},
    {kUnhomed, kStop, kStopping},
    {kUnhomed, kAbort, kStopping},
    {kIdle, kStart, kRunning},
    {kIdle, kStop, kStopping},
    {kIdle, kAbort, kStopping},
    {kIdle, kFail, kFault},
    {kRunning, kPoseDone, kRunning},
    {kRunning, kPause, kPausing},
    {kRunning, kStop, kStopping},
    {kRunning, kAbort, kStopping},
    {kRunning, kFail, kFault},
    {kPausing, kPoseDone, kPaused},
    {kPausing, kStop, kStopping},
    {kPausing, kAbort, kStopping},
    {kPausing, kFail, kFault},
    {kRunning, kTrip, kSuspended},
    {kSuspended, kClear, kRunning},
    {kSuspended, kStop, kStopping},
    {kSuspended, kAbort, kStopping},
    {kSuspended, kFail, kFault},
    {kPaused, kGoOn, kRunning},
    {kPaused, kStop, kStopping},
    {kPaused, kAbort, kStopping},
    {kPaused, kFail, kFault},  // what is logged of the pause
    {kStopping, kCleanedUp, kEnded},
    {kStopping, kFail, kFault},
    {kFault, kFail, kFault},
    {kFault, kCleanedUp, kFault},  // a fault is left by a new session only
};

}  // namespace

std::optional<SessionState> After(SessionState state, SessionSignal signal) {
  for (const Transition& transition : kTransitions) {
    if (transition.from == state && transition.signal == signal) return transition.to;
  }
  return std::nullopt;
}

const char* ToString(SessionState state) {
  switch (state) {
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
  }
  return "unknown";
}

}  // namespace gonio
