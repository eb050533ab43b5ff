// SPDX-License-Identifier: Apache-2.0
// Several axes of one Grbl, which makes one move after the other.
#include "drivers/grbl_machine.h"

#include <gmock/gmock.h>

#include <functional>
#include <optional>
#include <thread>

#include "tests/drivers/grbl_board.h"

namespace gonio::grbl {
namespace {

using testing::StartsWith;

class GrblAxes : public GrblTest {
 protected:
  void SetUp() override {
    SwitchOn();
    x_ = Opened('X', "light");
    y_ = Opened('Y', "camera");
    ASSERT_TRUE(x_->Home({}).ok());
    ASSERT_TRUE(y_->Home({}).ok());
  }
  // Starts both, of which the second has the longer way.
  void StartBoth() {
    ASSERT_TRUE(x_->StartMove(1).ok());
    clock_->SleepFor(Seconds(0.2));
    const auto expected = y_->StartMove(-1.5);
    ASSERT_TRUE(expected.ok()) << expected.error().message;
  }

  std::unique_ptr<Axis> x_;
  std::unique_ptr<Axis> y_;
};

TEST_F(GrblAxes, AreHomedTogetherAndOnce) {
  EXPECT_EQ(board_->Heard("$H"), 1);
  // To be homed again means just that.
  ASSERT_TRUE(x_->Home({}).ok());
  EXPECT_EQ(board_->Heard("$H"), 2);
  ASSERT_TRUE(y_->Home({}).ok());
  EXPECT_EQ(board_->Heard("$H"), 2);
  // As does homing one that has moved since, for it may have had a reason.
  ASSERT_TRUE(x_->Home({}).ok());
  ASSERT_TRUE(y_->StartMove(2).ok());
  EXPECT_EQ(WhyNotThere(*y_), "there");
  ASSERT_TRUE(y_->Home({}).ok());
  EXPECT_EQ(board_->Heard("$H"), 4);
}

TEST_F(GrblAxes, DoNotMoveOneAnother) {
  const double before = board_->Shaft(1);
  ASSERT_TRUE(x_->StartMove(1).ok());
  EXPECT_FALSE(y_->State()->moving);
  EXPECT_EQ(WhyNotThere(*x_), "there");
  EXPECT_NEAR(board_->Shaft(1), before, 1e-9);
}

// Example failure is a driver that queues the second move, which begins when the first one ends.
TEST_F(GrblAxes, MoveAtTheSameTime) {
  StartBoth();
  const double x = board_->Shaft(0);
  const double y = board_->Shaft(1);
  clock_->SleepFor(Seconds(0.5));
  EXPECT_NE(board_->Shaft(0), x);
  EXPECT_NE(board_->Shaft(1), y);
  EXPECT_TRUE(x_->State()->moving);
  EXPECT_TRUE(y_->State()->moving);
}

// Example failure is an axis that is told to be moving until all are still.
TEST_F(GrblAxes, ArriveEachInItsTime) {
  const Seconds begin = clock_->Now();
  StartBoth();
  EXPECT_EQ(WhyNotThere(*x_), "there");
  EXPECT_NEAR(Angle(0), 1, 1e-4);
  EXPECT_LT((clock_->Now() - begin).count(), 1.5 * (1.6 / 0.5) + 2);
  EXPECT_TRUE(y_->State()->moving);
  EXPECT_EQ(WhyNotThere(*y_), "there");
  EXPECT_NEAR(Angle(1), -1.5, 1e-4);
  EXPECT_NEAR(Angle(0), 1, 1e-4);
  EXPECT_LT((clock_->Now() - begin).count(), 1.5 * (4.1 / 0.5) + 2);
}

TEST_F(GrblAxes, TheOtherOneMayBeWaitedForFirst) {
  StartBoth();
  EXPECT_EQ(WhyNotThere(*y_), "there");
  EXPECT_EQ(WhyNotThere(*x_), "there");
}

TEST_F(GrblAxes, OneMayBeSentElsewhereOnItsWay) {
  StartBoth();
  clock_->SleepFor(Seconds(0.5));
  ASSERT_TRUE(x_->StartMove(2.5).ok());
  EXPECT_EQ(WhyNotThere(*x_), "there");
  EXPECT_NEAR(Angle(0), 2.5, 1e-4);
  EXPECT_EQ(WhyNotThere(*y_), "there");
  EXPECT_NEAR(Angle(1), -1.5, 1e-4);
}

// Grbl can stop all or nobody. Example failure is a driver that sends the other one on, while
// somebody stops one after the other.
TEST_F(GrblAxes, AStopStopsAll) {
  StartBoth();
  clock_->SleepFor(Seconds(0.5));
  ASSERT_TRUE(x_->Stop().ok());
  const double y = board_->Shaft(1);
  clock_->SleepFor(Seconds(1));
  EXPECT_EQ(board_->Shaft(1), y);
  EXPECT_THAT(WhyNotThere(*y_), StartsWith("camera: stands at "));
  // Still homed: it has braked.
  ASSERT_TRUE(x_->StartMove(1.5).ok());
  EXPECT_EQ(WhyNotThere(*x_), "there");
  EXPECT_EQ(board_->Shaft(1), y);
}

// Waits by what it is told to do instead.
struct BusyClock final : Clock {
  std::function<void()> wait;
  Seconds Now() const override { return Seconds(0); }
  void SleepFor(Seconds, std::stop_token) override { wait(); }
};

// Example failure is a start that waits for the others to brake, deaf, and then moves all the same.
TEST_F(GrblAxes, AStopReachesAStartThatWaitsForTheOthersToBrake) {
  x_.reset();
  y_.reset();
  machine_.reset();
  BusyClock clock;
  const auto opened =
      Machine::Open(OpenedPort(*line_), &clock, {.reply = kWireReplyLimit, .boot = Seconds(0.01)});
  ASSERT_TRUE(opened.ok()) << opened.error().message;
  Machine& machine = **opened;
  ASSERT_TRUE(machine.StartHoming(0).ok());
  while (!machine.Status(0)->homed) clock_->SleepFor(Seconds(0.1));
  ASSERT_TRUE(machine.StartMove(0, -100, 20).ok());
  // The board's time stands still, so that it would brake for ever.
  Result<void> stopped = Error{ErrorCode::kTimeout, "not called"};
  std::optional<std::thread> other;
  clock.wait = [&] {
    if (!other) other.emplace([&] { stopped = machine.Stop(); });
  };
  const auto started = machine.StartMove(1, -100, 20);
  other->join();
  ASSERT_FALSE(started.ok());
  EXPECT_EQ(started.error().code, ErrorCode::kCancelled);
  EXPECT_TRUE(stopped.ok());
  clock_->SleepFor(Seconds(1));
  EXPECT_FALSE(machine.Status(0)->moving);
  EXPECT_FALSE(machine.Status(1)->moving);
}

// Example failure is a goal that is remembered, and pursued when another axis starts.
TEST_F(GrblAxes, AMoveThatEndedShortIsNotResumed) {
  ASSERT_TRUE(x_->StartMove(-1).ok());
  clock_->SleepFor(Seconds(0.5));
  board_->Receive("\x85");
  clock_->SleepFor(Seconds(1));
  const double x = board_->Shaft(0);
  ASSERT_TRUE(y_->StartMove(1).ok());
  EXPECT_EQ(WhyNotThere(*y_), "there");
  EXPECT_NEAR(board_->Shaft(0), x, 1e-5);
}

TEST_F(GrblAxes, ARefusedMoveDoesNotStopTheOthers) {
  ASSERT_TRUE(x_->StartMove(1).ok());
  EXPECT_EQ(y_->StartMove(9).error().code, ErrorCode::kRefused);
  EXPECT_EQ(WhyNotThere(*x_), "there");
}

TEST_F(GrblAxes, AnEmergencyStopOfOneLosesAll) {
  StartBoth();
  ASSERT_TRUE(x_->EmergencyStop().ok());
  EXPECT_EQ(WhyNotThere(*y_), "camera: lost its reference on the way");
  EXPECT_FALSE(x_->State()->homed);
}

TEST_F(GrblAxes, AreNotHomedWhileOneMoves) {
  ASSERT_TRUE(x_->StartMove(1).ok());
  ASSERT_TRUE(y_->StartMove(2).ok());
  const auto homed = y_->Home({});
  ASSERT_FALSE(homed.ok());
  EXPECT_EQ(homed.error().message,
            "camera: " + line_->path() + ": cannot home while it is jogging");
}

}  // namespace
}  // namespace gonio::grbl
