// SPDX-License-Identifier: Apache-2.0
#include "acquisition/session_state.h"

#include <gmock/gmock.h>

#include <string>

#include "acquisition/session_record.h"
#include "tests/core/temp_dir.h"
#include "tests/scenario/bench.h"

namespace gonio {
namespace {

using enum SessionState;
using enum SessionSignal;
using testing::ElementsAre;

// The table of docs/sessions.md: rows are states, columns kHomed, kStart, kPause, kPoseDone, kGoOn,
// kTrip, kClear, kLost, kOpened, kCall, and then kStop, kAbort, kFail, kEmergency, kCleanedUp.
// Empty: the signal means nothing there.
TEST(SessionState, IsTheTableInTheDocumentation) {
  const std::string s = "stopping";
  const std::string f = "fault";
  const std::string e = "emergency stop";
  const std::string r = "running";
  const std::string d = "disconnected";
  const std::string p = "suspended";
  const std::string table[std::size(kSessionStates)][std::size(kSessionSignals)] = {
      /* disconnected */ {"", "", "", "", "", p, "", d, r, "paused", s, s, f, e, ""},
      /* unhomed      */ {"idle", "", "", "", "", "", "", "", "", "", s, s, f, e, ""},
      /* idle         */ {"", r, "", "", "", "", "", "", "", "", s, s, f, e, ""},
      /* running      */ {"", "", "pausing", r, "", p, "", d, "", "paused", s, s, f, e, ""},
      /* pausing      */ {"", "", "", "paused", "", "", "", "", "", "", s, s, f, e, ""},
      /* paused       */ {"", "", "", "", r, "", "", "", "", "", s, s, f, e, ""},
      /* suspended    */ {"", "", "", "", "", "", r, "", "", "", s, s, f, e, ""},
      /* stopping     */ {"", "", "", "", "", "", "", "", "", "", "", "", f, "", "ended"},
      /* ended        */ {"", "", "", "", "", "", "", "", "", "", "", "", "", "", ""},
      /* fault        */ {"", "", "", "", "", "", "", "", "", "", "", "", f, "", f},
      /* emergency    */ {"", "", "", "", "", "", "", "", "", "", "", "", e, "", e},
  };
  for (std::size_t i = 0; i < std::size(kSessionStates); ++i) {
    for (std::size_t j = 0; j < std::size(kSessionSignals); ++j) {
      const auto next = After(kSessionStates[i], kSessionSignals[j]);
      EXPECT_EQ(next ? std::string(ToString(*next)) : "", table[i][j])
          << ToString(kSessionStates[i]) << ", signal " << j;
    }
  }
}

std::vector<SessionState> StatesOf(Bench& bench, const SessionStop& stop, EventLog* log = nullptr) {
  std::vector<SessionState> states;
  ScriptedPlanner planner(FourPoses());
  RunSession({.rig = bench.rig,
              .devices = bench.devices,
              .clock = bench.clock,
              .planner = planner,
              .log = log,
              .on_state =
                  [&](SessionState state) {
                    if (states.empty() || states.back() != state) states.push_back(state);
                  }},
             {}, stop);
  return states;
}

TEST(SessionState, OfASessionThatIsPausedAndGoesOn) {
  const TempDir dir;
  Bench bench;
  int asked = 0;
  int waited = 0;
  {
    EventLog log = EventLog::Create(dir / "s", SomeInfo());
    const SessionStop stop{.after_pose = {},
                           .now = {},
                           .pause = [&] { return ++asked == 3; },
                           .wait =
                               [&] {
                                 ++waited;
                                 EXPECT_FALSE(bench.AnythingMoves());
                               }};
    EXPECT_THAT(StatesOf(bench, stop, &log),
                ElementsAre(kIdle, kRunning, kPausing, kPaused, kRunning, kStopping, kEnded));
  }
  EXPECT_EQ(waited, 1);
  std::vector<std::string> kinds;
  const SessionRecord record = ReadSession(dir / "s");
  for (const SessionEvent& event : record.events) kinds.push_back(event.kind);
  EXPECT_THAT(kinds, testing::IsSupersetOf({"paused", "continued"}));
  EXPECT_EQ(record.poses.size(), 4u);
}

TEST(SessionState, OfASessionThatEndsWhilePaused) {
  Bench bench;
  std::stop_source user;
  const SessionStop stop{.after_pose = user.get_token(),
                         .now = {},
                         .pause = [] { return true; },
                         .wait = [&] { user.request_stop(); }};
  EXPECT_THAT(StatesOf(bench, stop),
              ElementsAre(kIdle, kRunning, kPausing, kPaused, kStopping, kEnded));
  EXPECT_EQ(bench.lamp->level(), 0);
}

TEST(SessionState, OfASessionWhoseAxisIsGone) {
  Bench bench;
  bench.camera->on_capture = [&](int n) {
    if (n == 2) bench.axis(0).PullPlug();
  };
  EXPECT_THAT(StatesOf(bench, {}), ElementsAre(kIdle, kRunning, kFault));
}

}  // namespace
}  // namespace gonio
