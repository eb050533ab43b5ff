// SPDX-License-Identifier: Apache-2.0
// Against distances found another way: by points along the axes of the arms.
#include "acquisition/keep_out.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "acquisition/path_planner.h"
#include "sim/random.h"
#include "tests/acquisition/keep_out_rig.h"

namespace gonio {
namespace {

using testing::HasSubstr;

ArmAngles RandomPosition(const RigConfig& rig, Random& random) {
  ArmAngles angles{};
  for (int i = 0; i < kAxes; ++i) {
    const AxisLimits& axis = rig.axes[i];
    angles[i] = axis.min_position + random.Uniform() * (axis.max_position - axis.min_position);
  }
  return angles;
}

ArmAngles Between(const ArmAngles& low, const ArmAngles& high, Random& random) {
  ArmAngles angles{};
  for (int i = 0; i < kAxes; ++i) angles[i] = low[i] + random.Uniform() * (high[i] - low[i]);
  return angles;
}

TEST(KeepOut, FindsWhatIsNearerThanTheMargin) {
  const RigConfig rig = RigOfTwoPosts();
  const KeepOut keep_out(rig);
  Random random(1, 0);
  int contacts = 0;
  for (int i = 0; i < 3000; ++i) {
    const ArmAngles angles = RandomPosition(rig, random);
    const double gap = SampledGap(angles);
    if (std::abs(gap - rig.keep_out.margin) < 0.002) continue;  // the samples' own error
    const auto contact = keep_out.FindAt(angles);
    ASSERT_EQ(contact.has_value(), gap < rig.keep_out.margin) << gap;
    if (contact) {
      ++contacts;
      EXPECT_NEAR(contact->gap, std::max(0.0, gap), 0.03);  // another part may be nearer yet
    }
  }
  EXPECT_GT(contacts, 100);
}

// Example failure is a check of both ends, or along the straight line, while one arm is late.
TEST(KeepOut, ClearsABoxOnlyIfNothingInItTouches) {
  const RigConfig rig = RigOfTwoPosts();
  const KeepOut keep_out(rig);
  Random random(2, 0);
  int cleared = 0;
  for (int i = 0; i < 300; ++i) {
    const ArmAngles a = RandomPosition(rig, random);
    const ArmAngles b = Between(a, RandomPosition(rig, random), random);
    ArmAngles low{};
    ArmAngles high{};
    for (int k = 0; k < kAxes; ++k) std::tie(low[k], high[k]) = std::minmax(a[k], b[k]);
    const auto contact = keep_out.FindBetween(low, high);
    if (!contact) {
      ++cleared;
      for (int j = 0; j < 100; ++j) {
        ASSERT_GT(SampledGap(Between(low, high, random)), rig.keep_out.margin - 1e-4);
      }
    } else {
      // Where it says, it is near enough that a quarter of a degree decides.
      EXPECT_LT(SampledGap(contact->at), rig.keep_out.margin + 0.02) << contact->Text();
    }
  }
  EXPECT_GT(cleared, 30);
  EXPECT_LT(cleared, 270);
}

// Plays a path with axes that start at random times and go at random speeds.
void ExpectFree(const ArmAngles& from, const Path& path, double margin, Random& random) {
  ArmAngles here = from;
  for (const ArmAngles& leg : path) {
    for (int play = 0; play < 20; ++play) {
      ArmAngles start{};
      ArmAngles speed{};
      for (int i = 0; i < kAxes; ++i) {
        start[i] = random.Uniform();
        speed[i] = 0.5 + 3 * random.Uniform();
      }
      for (double t = 0; t < 3; t += 0.05) {
        ArmAngles at{};
        for (int i = 0; i < kAxes; ++i) {
          const double part = std::clamp((t - start[i]) * speed[i], 0.0, 1.0);
          at[i] = here[i] + part * (leg[i] - here[i]);
        }
        ASSERT_GT(SampledGap(at), margin - 1e-4);
      }
    }
    here = leg;
  }
}

TEST(PathPlanner, GoesAroundWhateverIsInTheWay) {
  const RigConfig rig = RigOfTwoPosts();
  const KeepOut keep_out(rig);
  const PathPlanner paths(rig);
  Random random(3, 0);
  int straight = 0;
  int around = 0;
  int none = 0;
  for (int i = 0; i < 60; ++i) {
    const ArmAngles from = RandomPosition(rig, random);
    const ArmAngles to = RandomPosition(rig, random);
    if (keep_out.FindAt(from) || keep_out.FindAt(to)) continue;
    const auto path = paths.Plan(from, to);
    if (!path) {
      EXPECT_EQ(path.error().code, ErrorCode::kRefused);
      ++none;
      continue;
    }
    EXPECT_EQ(path->back(), to);
    ++(path->size() == 1 ? straight : around);
    ExpectFree(from, *path, rig.keep_out.margin, random);
    EXPECT_GE(paths.TravelTime(from, *path), Kinematics(rig).TravelTime(from, to));
  }
  EXPECT_GT(straight, 5);
  EXPECT_GT(around, 10);
  EXPECT_LT(none, 6);  // a target within a quarter of a degree of a wall
}

TEST(PathPlanner, LiftsAnArmOverTheOther) {
  const PathPlanner paths(RigOfTwoPosts());
  const ArmAngles from = AnglesDeg(0, 30, 40, 30);
  const auto path = paths.Plan(from, AnglesDeg(0, 30, -40, 30));
  ASSERT_TRUE(path.ok()) << path.error().message;
  EXPECT_GE(path->size(), 2u);
}

TEST(PathPlanner, SaysWhatIsInTheWay) {
  const PathPlanner paths(RigOfTwoPosts());
  const ArmAngles free = AnglesDeg(0, 30, 90, 30);
  const ArmAngles touching = AnglesDeg(0, 30, 2, 30);
  const auto to = paths.Plan(free, touching);
  ASSERT_FALSE(to.ok());
  EXPECT_EQ(to.error().code, ErrorCode::kRefused);
  EXPECT_THAT(to.error().message, HasSubstr("light_arm 1 and camera_arm 1 come within"));
  const auto from = paths.Plan(touching, free);
  ASSERT_FALSE(from.ok());
  EXPECT_EQ(from.error().code, ErrorCode::kProtocol);
  EXPECT_THAT(from.error().message, HasSubstr("move them by hand"));
}

TEST(PathPlanner, KeepsCablesShort) {
  RigConfig rig = DefaultRig();
  rig.keep_out.max_azimuth_difference = RadFromDeg(200);
  const PathPlanner paths(rig);
  EXPECT_TRUE(paths.Plan(AnglesDeg(0, 30, 0, 60), AnglesDeg(-90, 30, 90, 60)).ok());
  const auto far = paths.Plan(AnglesDeg(0, 30, 0, 60), AnglesDeg(-120, 30, 90, 60));
  ASSERT_FALSE(far.ok());
  EXPECT_THAT(far.error().message, HasSubstr("the cables do not reach to light_azimuth -120"));
}

// Between two corridors of azimuth there is no way if an arm cannot be lifted out of them.
TEST(PathPlanner, DropsPosesThatAreCutOff) {
  RigConfig rig = RigOfTwoPosts();
  // A wall that the camera's arm cannot pass at any elevation it has.
  rig.axes[kCameraElevation].max_position = RadFromDeg(60);
  SolidPart wall{.shape = SolidPart::Shape::kBox, .from = {0.2, -0.02, -1}, .to = {1, 0.02, 1}};
  rig.keep_out.light_arm.clear();
  rig.keep_out.fixed = {wall};
  wall.from.x() = -1;
  wall.to.x() = -0.2;
  rig.keep_out.fixed.push_back(wall);
  rig.axes[kLightAzimuth].min_position = RadFromDeg(-1);  // it cannot turn the pair's azimuth
  rig.axes[kLightAzimuth].max_position = RadFromDeg(1);
  const PathPlanner paths(rig);
  // Mirrored, each pose is on both sides: what is cut off is reached as its mirror image.
  const std::vector<DirectionPair> poses = {PairAt(10, 40, 60), PairAt(20, 40, 60),
                                            PairAt(30, 40, 60)};
  EXPECT_THAT(paths.Connected(poses), testing::Each(true));
  const auto across = paths.Plan(AnglesDeg(0, 45, 90, 45), AnglesDeg(0, 45, -90, 45));
  ASSERT_FALSE(across.ok());
  EXPECT_THAT(across.error().message, HasSubstr("no way around"));
}

// The truth of the arms' positions, looked at while the session's clock runs.
class WatchedClock final : public Clock {
 public:
  Seconds Now() const override { return inner.Now(); }
  void SleepFor(Seconds duration, std::stop_token stop = {}) override {
    constexpr Seconds kStep{0.05};
    for (; duration > kStep; duration -= kStep) {
      inner.SleepFor(kStep, stop);
      if (watch) watch();
    }
    inner.SleepFor(duration + Seconds(1e-9), stop);  // never too short by rounding
    if (watch) watch();
  }
  ManualClock inner;
  std::function<void()> watch;
};

// The narrowest gap while sixty poses are measured one after the other.
double NarrowestOf(RigConfig rig) {
  rig.axes[kLightElevation].min_position = RadFromDeg(10);  // where it homes to: off the table
  WatchedClock clock;
  const FlatBrdf sample(Rgb::Constant(0.2));
  SimDevices sim = MakeSimDevices(
      DefaultTruth(), {rig.axes, rig.motion.home_limit, rig.camera, rig.imaging}, sample, clock, 1);
  Devices devices{std::move(sim.axes), std::move(sim.camera), std::move(sim.light),
                  std::move(sim.monitor)};
  PoseMeasurer measurer(rig, devices, clock);
  const auto prepared = measurer.Prepare({});
  EXPECT_TRUE(prepared.ok()) << prepared.error().message;
  double narrowest = 1;
  clock.watch = [&] {
    ArmAngles at{};
    for (int i = 0; i < kAxes; ++i) at[i] = sim.motors[i]->Position();
    narrowest = std::min(narrowest, SampledGap(at));
  };
  Random random(4, 0);
  for (int i = 0; i < 60; ++i) {
    const DirectionPair pair = Kinematics(rig).Forward(RandomPosition(rig, random));
    const auto measured = measurer.Measure(pair, std::nullopt, {});
    EXPECT_TRUE(measured || measured.error().code == ErrorCode::kRefused)
        << measured.error().message;
  }
  return narrowest;
}

TEST(KeepOutOnTheRig, ArmsNeverComeNearerThanTheMargin) {
  RigConfig rig = RigOfTwoPosts();
  EXPECT_GT(NarrowestOf(rig), rig.keep_out.margin - 5e-4);  // where moves end, they scatter
  rig.keep_out = {};
  EXPECT_LT(NarrowestOf(rig), 0.005);
}

TEST(ReadKeepOut, RefusesWhatIsNoSolid) {
  const auto why = [](const std::string& text) {
    try {
      (void)ReadKeepOut(ConfigNode::Parse(text, "rig.yaml"));
    } catch (const ConfigError& e) {
      return std::string(e.what());
    }
    return std::string("read");
  };
  EXPECT_EQ(why("margin_mm: 5\nfixed:\n- {box_from_mm: [0, 0, 0], box_to_mm: [1, 1, 1]}\n"),
            "read");
  EXPECT_EQ(why("margin_mm: 5\nfixed:\n- {box_from_mm: [0, 0, 0], box_to_mm: [1, 1, 0]}\n"),
            "rig.yaml:3: fixed[0].box_to_mm: must be > box_from_mm in each coordinate");
  EXPECT_EQ(why("margin_mm: -1\n"), "rig.yaml:1: margin_mm: is -1, must be >= 0");
  EXPECT_THAT(why("margin_mm: 5\nlight_arm:\n- {capsule_from_mm: [0, 0, 0], capsule_to_mm: [0, 0, "
                  "0], radius_mm: 5}\n"),
              HasSubstr("light_arm[0].capsule_to_mm: is capsule_from_mm"));
}

}  // namespace
}  // namespace gonio
