// SPDX-License-Identifier: Apache-2.0
// Sessions that are killed, over and over, at random times and at every call that writes to disk,
// and resumed until they are done: nothing lost, nothing twice, and the same fit.
//
// GONIO_KILL_SESSIONS=300 makes so many at random times instead of a few, and kills at every
// write instead of some.

#include <chrono>
#include <csignal>
#include <fstream>

#include "acquisition/event_log.h"
#include "acquisition/session_record.h"
#include "acquisition/wal_tail.h"
#include "sim/random.h"
#include "tests/apps/gonio_process.h"

namespace gonio {
namespace {

using testing::HasSubstr;

constexpr int kPoses = 12;

int SessionsWanted() {
  const char* text = std::getenv("GONIO_KILL_SESSIONS");
  return text == nullptr ? 5 : std::atoi(text);
}

class Kill : public GonioTest {
 protected:
  void SetUp() override {
    // Homing and time change nothing on this rig: arms end where they are sent, to the last bit,
    // and the light is steady. So all observations are those of a session that was never killed.
    std::string rig = Config("sim-rig.yaml");
    rig = With(rig, "repeatability_deg: 0.005", "repeatability_deg: 0");
    rig = With(rig, "encoder_resolution_deg: 0.002", "encoder_resolution_deg: 0");
    rig = With(rig, "light_drift_per_hour: 0.01", "light_drift_per_hour: 0");
    File("rig.yaml", rig);
    const auto begin = std::chrono::steady_clock::now();
    const Finished whole =
        Shell(fmt::format("GONIO_STORAGE_COUNT=count LD_PRELOAD={} \"$GONIO\" {}",
                          GONIO_STORAGE_SHIM, Begin("whole")));
    ASSERT_EQ(whole.code, 0) << whole.err;
    whole_time_ = std::chrono::steady_clock::now() - begin;
    calls_ = std::stol(ReadTextFile(work() / "count"));
    ASSERT_GT(calls_, 3 * kPoses);
  }

  static std::string Begin(const std::string& out) {
    return fmt::format("run --rig rig.yaml --max-poses {} --quiet --out {}", kPoses, out);
  }

  // Goes on with `out` until it is complete; `arm` says what ends each attempt early, if anything.
  void FinishAfterKills(const std::string& out, const std::function<Finished(std::string)>& run,
                        int limit) {
    Finished finished = run(Begin(out));
    for (int n = 0; finished.code != 0 && n < limit; ++n) {
      const bool nothing = finished.err.find("holds nothing yet") != std::string::npos;
      if (!nothing) {
        ASSERT_EQ(finished.code, 128 + SIGKILL) << finished.err;
        ++kills_;
      }
      const bool again = nothing || !std::filesystem::exists(work() / out / "session.sqlite");
      if (again) std::filesystem::remove_all(work() / out);  // killed while it was made
      finished = run(again ? Begin(out) : "run --quiet --resume " + out);
      if (finished.code == 2 && finished.err.find("is complete") != std::string::npos) {
        finished.code = 0;  // killed after the session's end: its fit is what is left to do
      }
    }
    ASSERT_EQ(finished.code, 0) << finished.err;
    ExpectAsWhole(out);
  }

  void ExpectAsWhole(const std::string& out) {
    const SessionRecord whole = ReadSession(work() / "whole");
    const SessionRecord killed = ReadSession(work() / out);
    ASSERT_EQ(killed.poses.size(), whole.poses.size()) << out;
    for (std::size_t i = 0; i < whole.poses.size(); ++i) {
      EXPECT_EQ(killed.poses[i].pose, whole.poses[i].pose);
      EXPECT_EQ(killed.poses[i].candidate, whole.poses[i].candidate) << out << " pose " << i + 1;
      EXPECT_EQ(killed.poses[i].readback, whole.poses[i].readback);
      ASSERT_EQ(killed.poses[i].samples.size(), whole.poses[i].samples.size());
      EXPECT_TRUE((killed.poses[i].samples[0].f_r == whole.poses[i].samples[0].f_r).all());
      EXPECT_TRUE((killed.poses[i].samples[0].sigma == whole.poses[i].samples[0].sigma).all());
    }
    Expect("replay " + out);
    // Killed after the session's end, its fit is left to do.
    if (!std::filesystem::exists(work() / out / "fit.yaml")) {
      Expect(fmt::format("fit {} --out {}/fit.yaml", out, out));
    }
    EXPECT_EQ(ReadTextFile(work() / out / "fit.yaml"), ReadTextFile(work() / "whole/fit.yaml"));
  }

  // Ends itself at the n-th call that writes to disk.
  Finished RunUntilCall(const std::string& arguments, long n, bool torn) {
    return Shell(fmt::format("GONIO_STORAGE_KILL={} {} LD_PRELOAD={} \"$GONIO\" {}", n,
                             torn ? "GONIO_STORAGE_TORN=1" : "", GONIO_STORAGE_SHIM, arguments));
  }

  // Killed from outside after so long, if it is not done before.
  Finished RunFor(const std::string& arguments, std::chrono::duration<double> time) {
    return Shell(fmt::format("timeout -s KILL {:.6f} \"$GONIO\" {}", time.count(), arguments));
  }

  std::chrono::duration<double> whole_time_{0};  // of a session, here and now
  long calls_ = 0;
  int kills_ = 0;
};

TEST_F(Kill, AtRandomTimes) {
  const int sessions = SessionsWanted();
  Random random(1, 0);
  for (int s = 0; s < sessions && !HasFatalFailure(); ++s) {
    // From before the session is made to beyond its end.
    FinishAfterKills(
        fmt::format("s{}", s),
        [&](const std::string& arguments) {
          return RunFor(arguments, (0.02 + 1.2 * random.Uniform()) * whole_time_);
        },
        200);
  }
  fmt::print("{} sessions, {} kills\n", sessions, kills_);
  RecordProperty("kills", kills_);
}

// Every transaction is a handful of writes and one flush; each of them is a place to die.
TEST_F(Kill, AtEveryWriteAndFlush) {
  const long step = SessionsWanted() > 5 ? 1 : std::max(1l, calls_ / 8);
  for (long n = 1; n <= calls_ && !HasFatalFailure(); n += step) {
    bool first = true;
    FinishAfterKills(
        fmt::format("w{}", n),
        [&](const std::string& arguments) {
          if (!std::exchange(first, false)) return Gonio(arguments);
          return RunUntilCall(arguments, n, n % 2 == 0);
        },
        3);
  }
  fmt::print("{} places, {} kills\n", calls_, kills_);
}

// The resume itself dies, again and again, each time a little later.
TEST_F(Kill, WhileItIsResumed) {
  EXPECT_EQ(RunUntilCall(Begin("r"), calls_ / 2, false).code, 128 + SIGKILL);
  for (long n = 1; n <= 40; n += 3) {
    const Finished finished = RunUntilCall("run --quiet --resume r", n, n % 2 == 0);
    if (finished.code == 0) break;
    ASSERT_EQ(finished.code, 128 + SIGKILL) << finished.err;
  }
  (void)Gonio("run --quiet --resume r");
  ExpectAsWhole("r");
}

// The disk is full at some size of the file, and then it is not.
TEST_F(Kill, WhenTheDiskIsFull) {
  const auto whole = std::filesystem::file_size(work() / "whole/session.sqlite");
  for (const double share : {0.4, 0.6, 0.9}) {
    const std::string out = fmt::format("f{}", static_cast<int>(10 * share));
    const long blocks = static_cast<long>(share * static_cast<double>(whole) / 1024);
    const Finished full =
        Shell(fmt::format("trap '' XFSZ; ulimit -f {}; \"$GONIO\" {}", blocks, Begin(out)));
    EXPECT_NE(full.code, 0);
    EXPECT_THAT(full.err, HasSubstr("cannot write"));
    if (!std::filesystem::exists(work() / out)) continue;  // too small to begin with
    Expect("run --quiet --resume " + out);
    ExpectAsWhole(out);
  }
}

// Pages of the one file.
TEST_F(Kill, WhenPagesAreDamaged) {
  const long half = calls_ / 2;
  EXPECT_EQ(RunUntilCall(Begin("d"), half, false).code, 128 + SIGKILL);
  { const EventLog closes = EventLog::Open(work() / "d"); }  // as one file
  const std::size_t before = ReadSession(work() / "d").poses.size();
  ASSERT_GT(before, 3u);
  std::fstream file(work() / "d/session.sqlite", std::ios::in | std::ios::out | std::ios::binary);
  file.seekp(-4000, std::ios::end);
  file << std::string(3000, 'x');
  file.close();
  const Finished refused = Gonio("run --resume d");
  EXPECT_EQ(refused.code, 2);
  EXPECT_THAT(refused.err, testing::AllOf(HasSubstr("is damaged"), HasSubstr("gonio rescue")));
  const Finished rescued = Gonio("rescue d --out k");
  EXPECT_EQ(rescued.code, 1) << rescued.out;
  EXPECT_THAT(rescued.out, testing::AllOf(HasSubstr("damage "), HasSubstr("lost ")));
  Expect("rescue k");
  const std::size_t kept = ReadSession(work() / "k").poses.size();
  EXPECT_GE(kept + 2, before);
  const Finished resumed = Gonio("run --quiet --accept-changed --resume k");
  EXPECT_EQ(resumed.code, 0) << resumed.err;
  EXPECT_EQ(ReadSession(work() / "k").poses.size(), static_cast<std::size_t>(kPoses));
  Expect("replay k");
}

// The newest of the write-ahead log: what was acknowledged is lost, which must be said.
TEST_F(Kill, WhenTheLogsLastPageIsDamaged) {
  const std::filesystem::path wal = work() / "d/session.sqlite-wal";
  WalTail tail;
  // Not where it is killed in the middle of a page: that may look like the damage to come.
  for (long n = calls_ / 2; tail.committed == 0 || tail.damaged > 0; ++n) {
    ASSERT_LE(n, calls_);
    std::filesystem::remove_all(work() / "d");
    EXPECT_EQ(RunUntilCall(Begin("d"), n, false).code, 128 + SIGKILL);
    tail = ReadWalTail(wal);
  }
  std::fstream file(wal, std::ios::in | std::ios::out | std::ios::binary);
  const std::streamoff frame = 4096 + 24;
  file.seekp(32 + (tail.committed - 1) * frame + 100);
  file << "xxxx";
  file.close();
  EXPECT_GT(ReadWalTail(wal).damaged, 0);
  EXPECT_LT(ReadWalTail(wal).committed, tail.committed);
  const Finished resumed = Gonio("run --quiet --resume d");
  EXPECT_EQ(resumed.code, 0) << resumed.err;
  EXPECT_THAT(resumed.err, HasSubstr("of the write-ahead log"));
  ExpectAsWhole("d");
}

}  // namespace
}  // namespace gonio
