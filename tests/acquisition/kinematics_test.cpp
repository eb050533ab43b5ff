// SPDX-License-Identifier: Apache-2.0
#include "acquisition/kinematics.h"

#include <gmock/gmock.h>

#include <random>

#include "tests/acquisition/simulated_rig.h"

namespace gonio {
namespace {

using testing::DoubleNear;

class Draw {
 public:
  explicit Draw(unsigned seed) : engine_(seed) {}
  double Between(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(engine_);
  }
  // Anywhere above the horizon; the azimuths are not equal.
  DirectionPair Pair() {
    return {FromSpherical(Between(0, kPi / 2 - 1e-3), Between(-4, 4)),
            FromSpherical(Between(0, kPi / 2 - 1e-3), Between(-4, 4))};
  }
  ArmAngles Position(const RigConfig& rig) {
    ArmAngles angles{};
    for (int i = 0; i < kAxes; ++i) {
      angles[i] = Between(rig.axes[i].min_position, rig.axes[i].max_position);
    }
    return angles;
  }

 private:
  std::mt19937 engine_;
};

// Both azimuths in narrow ranges that force common turns, mirroring and refusals.
RigConfig NarrowRig() {
  RigConfig rig = DefaultRig();
  rig.axes[kLightAzimuth].min_position = RadFromDeg(-30);
  rig.axes[kLightAzimuth].max_position = RadFromDeg(40);
  rig.axes[kCameraAzimuth].min_position = RadFromDeg(100);
  rig.axes[kCameraAzimuth].max_position = RadFromDeg(200);
  rig.axes[kCameraAzimuth].max_speed /= 4;
  return rig;
}

// An isotropic sample sees no difference between pairs that agree in these.
void ExpectSameForIsotropicSample(const DirectionPair& a, const DirectionPair& b) {
  EXPECT_THAT(a.wi.z(), DoubleNear(b.wi.z(), 1e-6));
  EXPECT_THAT(a.wo.z(), DoubleNear(b.wo.z(), 1e-6));
  EXPECT_THAT(AngleBetween(a.wi, a.wo), DoubleNear(AngleBetween(b.wi, b.wo), 1e-6));
}

void ExpectInsideLimits(const ArmAngles& angles, const RigConfig& rig) {
  for (int i = 0; i < kAxes; ++i) {
    EXPECT_GE(angles[i], rig.axes[i].min_position) << kAxisNames[i];
    EXPECT_LE(angles[i], rig.axes[i].max_position) << kAxisNames[i];
  }
}

// The fastest solution on a fine raster of light azimuths; empty if it holds none.
std::optional<Seconds> FastestOnRaster(const DirectionPair& pair, const ArmAngles& from,
                                       const RigConfig& rig) {
  const Kinematics kinematics(rig);
  const AxisLimits& light = rig.axes[kLightAzimuth];
  const AxisLimits& camera = rig.axes[kCameraAzimuth];
  const auto azimuth = [](const Eigen::Vector3d& v) { return std::atan2(v.y(), v.x()); };
  const double difference = azimuth(pair.wo) - azimuth(pair.wi);
  std::optional<Seconds> best;
  for (double a = light.min_position; a <= light.max_position; a += RadFromDeg(0.25)) {
    for (const double mirrored : {difference, -difference}) {
      for (int turn = -3; turn <= 3; ++turn) {
        const double b = a + mirrored + 2 * kPi * turn;
        if (b < camera.min_position || b > camera.max_position) continue;
        const ArmAngles to = {a, std::asin(pair.wi.z()), b, std::asin(pair.wo.z())};
        const Seconds time = kinematics.TravelTime(from, to);
        if (!best || time < *best) best = time;
      }
    }
  }
  return best;
}

TEST(Kinematics, ForwardPointsWhereTheAxesSay) {
  const Kinematics kinematics(DefaultRig());
  const DirectionPair pair = kinematics.Forward(AnglesDeg(90, 30, 180, 90));
  EXPECT_NEAR((pair.wi - FromSpherical(RadFromDeg(60), RadFromDeg(90))).norm(), 0, 1e-12);
  EXPECT_NEAR((pair.wo - Eigen::Vector3d::UnitZ()).norm(), 0, 1e-12);
}

class KinematicsOn : public testing::TestWithParam<bool> {
 protected:
  const RigConfig rig_ = GetParam() ? NarrowRig() : DefaultRig();
  const Kinematics kinematics_{rig_};
};
INSTANTIATE_TEST_SUITE_P(Rigs, KinematicsOn, testing::Values(false, true),
                         [](const auto& rig) { return rig.param ? "Narrow" : "Default"; });

TEST_P(KinematicsOn, ForwardOfInverseIsThePairUpToSymmetryAndLimitsHold) {
  Draw draw(1);
  int solved = 0;
  for (int i = 0; i < 20000; ++i) {
    const DirectionPair pair = draw.Pair();
    const auto angles = kinematics_.Inverse(pair, draw.Position(rig_));
    if (!angles) continue;
    ++solved;
    ExpectInsideLimits(*angles, rig_);
    ExpectSameForIsotropicSample(kinematics_.Forward(*angles), pair);
  }
  EXPECT_GT(solved, 5000);
}

TEST_P(KinematicsOn, ReachableAgreesWithInverseFromAnywhere) {
  Draw draw(2);
  for (int i = 0; i < 5000; ++i) {
    const DirectionPair pair = draw.Pair();
    EXPECT_EQ(kinematics_.Reachable(pair),
              kinematics_.Inverse(pair, draw.Position(rig_)).has_value());
  }
}

TEST_P(KinematicsOn, EveryPositionOfTheAxesIsReachableUnlessTheGeometryForbidsIt) {
  Draw draw(3);
  for (int i = 0; i < 5000; ++i) {
    const DirectionPair pair = kinematics_.Forward(draw.Position(rig_));
    const bool allowed = std::acos(pair.wi.z()) <= rig_.geometry.max_polar &&
                         std::acos(pair.wo.z()) <= rig_.geometry.max_polar &&
                         AngleBetween(pair.wi, pair.wo) >= rig_.geometry.min_separation;
    EXPECT_EQ(kinematics_.Reachable(pair), allowed);
  }
}

TEST_P(KinematicsOn, InverseIsNeverSlowerThanAnExhaustiveSearch) {
  Draw draw(4);
  for (int i = 0; i < 300; ++i) {
    const DirectionPair pair = draw.Pair();
    const ArmAngles from = draw.Position(rig_);
    const auto angles = kinematics_.Inverse(pair, from);
    if (!angles) continue;
    const auto raster = FastestOnRaster(pair, from, rig_);
    if (raster) {
      EXPECT_LE(kinematics_.TravelTime(from, *angles).count(), raster->count() + 1e-9);
    }
  }
}

TEST_P(KinematicsOn, LimitsThemselvesAreInReach) {
  for (const bool low : {true, false}) {
    ArmAngles corner{};
    for (int i = 0; i < kAxes; ++i) {
      corner[i] = low ? rig_.axes[i].min_position : rig_.axes[i].max_position;
    }
    // Inside the keep-outs, which are not the subject here.
    corner[kLightElevation] = RadFromDeg(4);
    corner[kCameraElevation] = RadFromDeg(30);
    const auto angles = kinematics_.Inverse(kinematics_.Forward(corner), corner);
    ASSERT_TRUE(angles.has_value());
    ExpectInsideLimits(*angles, rig_);
    EXPECT_NEAR(kinematics_.TravelTime(corner, *angles).count(), 0, 1e-3);
  }
}

TEST(Kinematics, StaysWhereItIsForThePoseItIsAt) {
  const RigConfig rig = DefaultRig();
  const Kinematics kinematics(rig);
  const ArmAngles from = AnglesDeg(-100, 50, 60, 20);
  const auto angles = kinematics.Inverse(kinematics.Forward(from), from);
  ASSERT_TRUE(angles.has_value());
  for (int i = 0; i < kAxes; ++i) EXPECT_NEAR((*angles)[i], from[i], 1e-9);
}

TEST(Kinematics, TakesTheMirroredSolutionWhenItIsNearer) {
  const Kinematics kinematics(DefaultRig());
  // Camera 90 deg to the left of the light is asked for; it stands 90 deg to the right.
  const ArmAngles from = AnglesDeg(0, 45, -90, 45);
  const auto angles = kinematics.Inverse(kinematics.Forward(AnglesDeg(0, 45, 90, 45)), from);
  ASSERT_TRUE(angles.has_value());
  EXPECT_NEAR(kinematics.TravelTime(from, *angles).count(), 0, 1e-4);
}

TEST(Kinematics, SharesATurnBetweenBothArms) {
  const Kinematics kinematics(DefaultRig());
  const ArmAngles from = AnglesDeg(0, 45, 60, 45);
  const auto angles = kinematics.Inverse(kinematics.Forward(AnglesDeg(0, 45, 100, 45)), from);
  ASSERT_TRUE(angles.has_value());
  EXPECT_NEAR((*angles)[kLightAzimuth], RadFromDeg(-20), 1e-6);
  EXPECT_NEAR((*angles)[kCameraAzimuth], RadFromDeg(80), 1e-6);
}

TEST(Kinematics, MovesOneArmOnlyWhenThatIsAsFast) {
  const Kinematics kinematics(DefaultRig());
  // The elevation takes longer than the 10 deg of azimuth, whoever turns.
  const ArmAngles from = AnglesDeg(0, 45, 60, 10);
  const auto angles = kinematics.Inverse(kinematics.Forward(AnglesDeg(0, 45, 70, 80)), from);
  ASSERT_TRUE(angles.has_value());
  EXPECT_EQ((*angles)[kLightAzimuth], from[kLightAzimuth]);
}

TEST(Kinematics, KeepsBothAzimuthsAtTheZenith) {
  const Kinematics kinematics(DefaultRig());
  const ArmAngles from = AnglesDeg(33, 45, -150, 20);
  const DirectionPair from_above = {Eigen::Vector3d::UnitZ(), FromSpherical(RadFromDeg(40), 2.0)};
  for (const DirectionPair& pair : {from_above, DirectionPair{from_above.wo, from_above.wi}}) {
    const auto angles = kinematics.Inverse(pair, from);
    ASSERT_TRUE(angles.has_value());
    EXPECT_EQ((*angles)[kLightAzimuth], from[kLightAzimuth]);
    EXPECT_EQ((*angles)[kCameraAzimuth], from[kCameraAzimuth]);
  }
}

TEST(Kinematics, RefusesHorizonPolarAngleAndSeparation) {
  const RigConfig rig = DefaultRig();
  const Kinematics kinematics(rig);
  const auto pair = [](double theta_i_deg, double theta_o_deg, double phi_deg) {
    return DirectionPair{FromSpherical(RadFromDeg(theta_i_deg), 0),
                         FromSpherical(RadFromDeg(theta_o_deg), RadFromDeg(phi_deg))};
  };
  EXPECT_TRUE(kinematics.Reachable(pair(86, 0, 0)));
  EXPECT_FALSE(kinematics.Reachable(pair(86.01, 0, 0)));
  EXPECT_FALSE(kinematics.Reachable(pair(0, 86.01, 0)));
  EXPECT_FALSE(kinematics.Reachable(pair(95, 0, 0)));
  EXPECT_FALSE(kinematics.Reachable(pair(10, 120, 0)));
  EXPECT_TRUE(kinematics.Reachable(pair(40, 43.001, 0)));
  EXPECT_FALSE(kinematics.Reachable(pair(40, 42.999, 0)));
  EXPECT_FALSE(kinematics.Reachable(pair(40, 40, 1)));
}

TEST(Kinematics, TravelTimeIsThatOfTheSlowestAxis) {
  RigConfig rig = DefaultRig();
  rig.axes[kCameraElevation].max_speed = RadFromDeg(1);
  const Kinematics kinematics(rig);
  const ArmAngles from = AnglesDeg(0, 45, 0, 45);
  // 100 deg at 20 deg/s, ramps of half a second: 5.5 s.
  EXPECT_NEAR(kinematics.TravelTime(from, AnglesDeg(-100, 45, 30, 45)).count(), 5.5, 1e-12);
  // 10 deg at 1 deg/s, ramps of 25 ms.
  EXPECT_NEAR(kinematics.TravelTime(from, AnglesDeg(-100, 45, 30, 55)).count(), 10.025, 1e-12);
  EXPECT_EQ(kinematics.TravelTime(from, from).count(), 0);
}

TEST(Kinematics, EveryMoveOfAnAxisCostsItsOverheadButStandingStillCostsNothing) {
  RigConfig rig = DefaultRig();
  rig.axes[kLightElevation].move_overhead = Seconds(68);
  const Kinematics kinematics(rig);
  const ArmAngles from = AnglesDeg(-100, 45, 30, 45);
  // 10 deg at 20 deg/s and 40 deg/s^2: one second.
  EXPECT_NEAR(kinematics.TravelTime(from, AnglesDeg(-100, 45, 30, 55)).count(), 1, 1e-9);
  EXPECT_NEAR(kinematics.TravelTime(from, AnglesDeg(-100, 55, 30, 45)).count(), 69, 1e-9);
  EXPECT_NEAR(kinematics.TravelTime(from, AnglesDeg(-100, 55, 30, 55)).count(), 69, 1e-9);
  EXPECT_EQ(kinematics.TravelTime(from, AnglesDeg(-100, 45.04, 30, 45)).count(), 0);
}

TEST(Kinematics, WaitsForTheArmWhoseMovesCostLess) {
  RigConfig rig = DefaultRig();
  rig.axes[kLightAzimuth].move_overhead = Seconds(20);
  const Kinematics kinematics(rig);
  const ArmAngles from = AnglesDeg(0, 45, 90, 45);
  const auto angles = kinematics.Inverse(kinematics.Forward(AnglesDeg(-10, 45, 120, 45)), from);
  ASSERT_TRUE(angles);
  EXPECT_EQ((*angles)[kLightAzimuth], from[kLightAzimuth]);
}

TEST(Kinematics, LeavesRoomForTheApproach) {
  RigConfig rig = DefaultRig();
  const DirectionPair highest =
      Kinematics(rig).Forward({0, rig.axes[kLightElevation].max_position, kPi / 2, kPi / 4});
  EXPECT_TRUE(Kinematics(rig).Reachable(highest));
  rig.axes[kLightElevation].approach = RadFromDeg(1);
  EXPECT_TRUE(Kinematics(rig).Reachable(highest));
  rig.axes[kLightElevation].approach = RadFromDeg(-1);
  EXPECT_FALSE(Kinematics(rig).Reachable(highest));
}

// Example failure is an offset that is added on the way out and on the way back.
TEST(Kinematics, CalibratedOffsetsComeOnTopOfTheEncoders) {
  RigConfig rig = DefaultRig();
  rig.axis_offsets = {0.01, -0.02, 0.03, 0.015};
  const Kinematics kinematics(rig);
  const ArmAngles encoders = {0.2, 0.9, -1.5, 1.1};
  const DirectionPair pair = kinematics.Forward(encoders);
  const DirectionPair truly = Kinematics(DefaultRig()).Forward({0.21, 0.88, -1.47, 1.115});
  EXPECT_LT((pair.wi - truly.wi).norm(), 1e-12);
  EXPECT_LT((pair.wo - truly.wo).norm(), 1e-12);
  const auto back = kinematics.Inverse(pair, encoders);
  ASSERT_TRUE(back);
  for (int i = 0; i < kAxes; ++i) EXPECT_NEAR((*back)[i], encoders[i], 1e-9);
  // An elevation that only an encoder beyond its limit would give is out of reach.
  const double lowest = rig.axes[kLightElevation].min_position - 0.02;
  const DirectionPair low = {FromSpherical(kPi / 2 - lowest + 1e-3, 0), truly.wo};
  EXPECT_FALSE(kinematics.Reachable(low));
}

TEST(Kinematics, TravelsByTheTimeModel) {
  RigConfig rig = DefaultRig();
  const ArmAngles there = {0, 1, 0, 0};
  const Seconds believed = Kinematics(rig).TravelTime({}, there);
  rig.time_model.emplace();
  for (int i = 0; i < kAxes; ++i) {
    rig.time_model->max_speed[i] = rig.axes[i].max_speed / 2;
    rig.time_model->acceleration[i] = rig.axes[i].acceleration / 4;
    rig.time_model->move_overhead[i] = Seconds(0.25);
  }
  // Half the speed and a quarter of the acceleration: the same profile, stretched.
  EXPECT_NEAR(Kinematics(rig).TravelTime({}, there).count(), 2 * believed.count() + 0.25, 1e-9);
}

}  // namespace
}  // namespace gonio
