// SPDX-License-Identifier: Apache-2.0
// Every kind of rig against the simulator's own geometry.
#include "tests/acquisition/rig_kinds.h"

#include <gmock/gmock.h>

#include <cmath>

#include "acquisition/image_regions.h"
#include "acquisition/kinematics.h"
#include "acquisition/path_planner.h"
#include "acquisition/reach.h"
#include "sim/sim_optics.h"

namespace gonio {
namespace {

using testing::HasSubstr;

class RigKinds : public testing::TestWithParam<KindOfRig> {
 protected:
  const RigConfig rig_ = RigOf(GetParam());
  const Kinematics kinematics_{rig_};
  Random random_{11, 0};

  DirectionPair Truth(const AxisPositions& positions) const {
    return Place(GetParam().truth, positions).directions();
  }
  DirectionPair SomePair() {
    return ToDirections({.theta_h = random_.Uniform() * kPi / 2,
                         .theta_d = random_.Uniform() * kPi / 2,
                         .phi_d = IsInPlane(rig_.geometry.kind) ? 0 : random_.Uniform() * kPi});
  }
  bool Allowed(const DirectionPair& pair) const {
    const auto polar = [](const Eigen::Vector3d& w) {
      return std::atan2(std::hypot(w.x(), w.y()), w.z());
    };
    return pair.above_horizon() && polar(pair.wi) <= rig_.geometry.max_polar &&
           polar(pair.wo) <= rig_.geometry.max_polar &&
           AngleBetween(pair.wi, pair.wo) >= rig_.geometry.min_separation;
  }
};
INSTANTIATE_TEST_SUITE_P(All, RigKinds, testing::ValuesIn(kEveryKind), NameOf);

// Example failure is a sample that turns the other way than its directions.
TEST_P(RigKinds, PointWhereTheSimulatedMachinePoints) {
  for (int i = 0; i < 2000; ++i) {
    const AxisPositions positions = RandomPositions(rig_, random_);
    const DirectionPair truth = Truth(positions);
    const DirectionPair pair = kinematics_.Forward(positions);
    ASSERT_LT((pair.wi - truth.wi).norm(), 1e-12);
    ASSERT_LT((pair.wo - truth.wo).norm(), 1e-12);
  }
}

// Reciprocity is not one of the symmetries: light and camera are not exchanged.
TEST_P(RigKinds, GoBackToThePairUpToSymmetryInsideTheLimits) {
  int solved = 0;
  for (int i = 0; i < 5000; ++i) {
    const DirectionPair pair = SomePair();
    for (const AxisPositions& to : kinematics_.Solutions(pair, RandomPositions(rig_, random_))) {
      ++solved;
      for (int a = 0; a < rig_.axis_count; ++a) {
        ASSERT_GE(to[a], rig_.axes[a].min_position) << rig_.axis_names()[a];
        ASSERT_LE(to[a], rig_.axes[a].max_position) << rig_.axis_names()[a];
      }
      const DirectionPair there = Truth(to);
      ASSERT_NEAR(there.wi.z(), pair.wi.z(), 1e-9);
      ASSERT_NEAR(there.wo.z(), pair.wo.z(), 1e-9);
      ASSERT_NEAR(there.wi.dot(there.wo), pair.wi.dot(pair.wo), 1e-9);
    }
  }
  EXPECT_GT(solved, 3000);
}

TEST_P(RigKinds, ReachWhateverSomePositionShowsUnlessTheGeometryForbidsIt) {
  int allowed = 0;
  for (int i = 0; i < 5000; ++i) {
    const DirectionPair pair = Truth(RandomPositions(rig_, random_));
    allowed += Allowed(pair) ? 1 : 0;
    ASSERT_EQ(kinematics_.Reachable(pair), Allowed(pair)) << i;
  }
  EXPECT_GT(allowed, 500);
}

// Of random positions that show the same, none is reached sooner.
TEST_P(RigKinds, TakeTheSoonestWay) {
  for (int i = 0; i < 300; ++i) {
    const AxisPositions from = RandomPositions(rig_, random_);
    const AxisPositions other = RandomPositions(rig_, random_);
    const auto to = kinematics_.Inverse(Truth(other), from);
    if (!to) continue;
    ASSERT_LE(kinematics_.TravelTime(from, *to),
              kinematics_.TravelTime(from, other) + Seconds(1e-9));
    const auto stay = kinematics_.Inverse(Truth(*to), *to);
    ASSERT_TRUE(stay.has_value());
    for (int a = 0; a < rig_.axis_count; ++a) ASSERT_NEAR((*stay)[a], (*to)[a], 1e-7);
  }
}

TEST_P(RigKinds, PutEncodersOffsetsOnTop) {
  RigConfig off = rig_;
  for (int a = 0; a < rig_.axis_count; ++a) off.axis_offsets[a] = 0.01 * (a + 1);
  const Kinematics kinematics(off);
  AxisPositions encoders{};
  AxisPositions truly{};
  for (int a = 0; a < rig_.axis_count; ++a) {
    const AxisLimits& axis = rig_.axes[a];
    encoders[a] = axis.min_position + (0.3 + 0.15 * a) * (axis.max_position - axis.min_position);
    truly[a] = encoders[a] + off.axis_offsets[a];
  }
  EXPECT_LT((kinematics.Forward(encoders).wo - Truth(truly).wo).norm(), 1e-12);
  const auto back = kinematics.Inverse(kinematics.Forward(encoders), encoders);
  ASSERT_TRUE(back.has_value());
  for (int a = 0; a < rig_.axis_count; ++a) EXPECT_NEAR((*back)[a], encoders[a], 1e-9);
}

// Each pixel is a region of its own; the simulator's image is asked where that pixel looks.
TEST_P(RigKinds, SeeWithEachPixelWhatTheSimulatedCameraSees) {
  const int side = 8;
  Imaging imaging;
  imaging.focal_length = 100;
  imaging.camera_distance = 0.5;
  imaging.light_distance = 0.8;
  SimConfig truth = DefaultTruth();
  truth.rig = GetParam().truth;
  const SimOptics optics(truth, imaging, side, side);
  int pixels = 0;
  for (int i = 0; i < 200; ++i) {
    const AxisPositions positions = RandomPositions(rig_, random_);
    if (!Allowed(Truth(positions))) continue;
    for (const ImageRegion& region :
         RegionsOf(kinematics_.ImagingAt(imaging, positions), kinematics_.TrueAngles(positions),
                   side, side, rig_.geometry.max_polar, side * side)) {
      if (region.pixels.size() != 1) continue;
      const auto pixel = static_cast<int>(region.pixels[0]);
      const auto seen = optics.See(positions, pixel % side, pixel / side);
      ASSERT_TRUE(seen.has_value());
      ASSERT_LT((seen->local.wi - region.directions.wi).norm(), 1e-9);
      ASSERT_LT((seen->local.wo - region.directions.wo).norm(), 1e-9);
      ++pixels;
    }
  }
  EXPECT_GT(pixels, 1000);
}

// ---- keep-out

class BarsOn : public testing::TestWithParam<KindOfRig> {
 protected:
  const RigConfig rig_ = RigOfBars(GetParam());
  const KeepOut keep_out_{rig_};
  Random random_{12, 0};

  double Gap(const AxisPositions& positions) const {
    return SampledGap(rig_, GetParam().truth, positions);
  }
  AxisPositions Between(const AxisPositions& low, const AxisPositions& high) {
    AxisPositions positions{};
    for (int i = 0; i < kAxes; ++i) positions[i] = low[i] + random_.Uniform() * (high[i] - low[i]);
    return positions;
  }
};
INSTANTIATE_TEST_SUITE_P(All, BarsOn, testing::ValuesIn(kEveryKind), NameOf);

TEST_P(BarsOn, AreFoundWhereTheyTouch) {
  int contacts = 0;
  for (int i = 0; i < 3000; ++i) {
    const AxisPositions positions = RandomPositions(rig_, random_);
    const double gap = Gap(positions);
    if (std::abs(gap - rig_.keep_out.margin) < 0.002) continue;  // the samples' own error
    const auto contact = keep_out_.FindAt(positions);
    ASSERT_EQ(contact.has_value(), gap < rig_.keep_out.margin) << gap;
    if (contact) ++contacts;
  }
  EXPECT_GT(contacts, 100);
  EXPECT_LT(contacts, 2900);
}

// Example failure is an arm checked against the sample as it stands at the end of the move.
TEST_P(BarsOn, AreClearInABoxOnlyIfNothingInItTouches) {
  int cleared = 0;
  int blocked = 0;
  for (int i = 0; i < 400; ++i) {
    const AxisPositions a = RandomPositions(rig_, random_);
    const AxisPositions b = Between(a, Between(a, RandomPositions(rig_, random_)));
    AxisPositions low{};
    AxisPositions high{};
    for (int k = 0; k < kAxes; ++k) std::tie(low[k], high[k]) = std::minmax(a[k], b[k]);
    const auto contact = keep_out_.FindBetween(low, high);
    if (contact) {
      ++blocked;
      // Where it says, it is near enough that a quarter of a degree decides.
      EXPECT_LT(Gap(contact->at), rig_.keep_out.margin + 0.02) << contact->Text();
      continue;
    }
    ++cleared;
    for (int j = 0; j < 100; ++j) ASSERT_GT(Gap(Between(low, high)), rig_.keep_out.margin - 1e-4);
  }
  EXPECT_GT(cleared, 30);
  EXPECT_GT(blocked, 30);
}

// Legs are played with axes that start at random times and go at random speeds.
TEST_P(BarsOn, AreKeptAwayFromInWhateverOrderAxesArrive) {
  const PathPlanner paths(rig_);
  int found = 0;
  for (int i = 0; i < 40; ++i) {
    AxisPositions here = RandomPositions(rig_, random_);
    const AxisPositions to = RandomPositions(rig_, random_);
    if (keep_out_.FindAt(here) || keep_out_.FindAt(to)) continue;
    const auto path = paths.Plan(here, to);
    if (!path) continue;
    ++found;
    EXPECT_EQ(path->back(), to);
    for (const AxisPositions& leg : *path) {
      for (int play = 0; play < 200; ++play) {
        AxisPositions at{};
        for (int a = 0; a < kAxes; ++a) at[a] = here[a] + random_.Uniform() * (leg[a] - here[a]);
        ASSERT_GT(Gap(at), rig_.keep_out.margin - 1e-4);
      }
      here = leg;
    }
  }
  EXPECT_GT(found, 5);
}

TEST_P(BarsOn, AreNamedWithTheAxesOfTheRig) {
  for (int i = 0; i < 3000; ++i) {
    const auto contact = keep_out_.FindAt(RandomPositions(rig_, random_));
    if (!contact) continue;
    for (const char* axis : rig_.axis_names()) EXPECT_THAT(contact->Text(), HasSubstr(axis));
    EXPECT_THAT(contact->Text(), testing::Not(HasSubstr("elevation 0.0, elevation")));
    return;
  }
  FAIL() << "nothing touches";
}

// ---- the turntable

TEST(Turntable, ReachesItsPlaneOnly) {
  const Kinematics kinematics(RigOf(kEveryKind[1]));
  EXPECT_TRUE(kinematics.Reachable(PairAt(20, 40, 0)));
  EXPECT_TRUE(kinematics.Reachable(PairAt(20, 40, 180)));
  EXPECT_FALSE(kinematics.Reachable(PairAt(20, 40, 90)));
  EXPECT_FALSE(kinematics.Reachable(PairAt(20, 40, 1)));
  EXPECT_TRUE(kinematics.Reachable(PairAt(0, 40, 0)));
  EXPECT_FALSE(kinematics.Reachable(PairAt(60, 40, 0)));  // below the horizon
}

TEST(Turntable, LeavesTheSampleWhereItStands) {
  const Kinematics kinematics(RigOf(kEveryKind[1]));
  const AxisPositions from = {0.5, 2.0, 1.2};
  const auto to = kinematics.Inverse(PairAt(20, 40, 0), from);
  ASSERT_TRUE(to.has_value());
  EXPECT_EQ((*to)[turntable::kSampleTurn], 1.2);
}

// A holder stands over the sample on one side; turned away, it leaves the plane to the arms.
TEST(Turntable, TurnsTheSampleOutOfTheArmsWay) {
  RigConfig rig = RigOf(kEveryKind[1]);
  rig.keep_out = {.margin = 0.01,
                  .light_arm = {},
                  .camera_arm = {},
                  .sample = {},
                  .fixed = {},
                  .max_azimuth_difference = {}};
  rig.keep_out.light_arm = {{.from = {0.2, 0, 0}, .to = {0.7, 0, 0}, .radius = 0.03}};
  rig.keep_out.camera_arm = rig.keep_out.light_arm;
  rig.keep_out.sample = {{.from = {-0.3, 0, 0}, .to = {0.3, 0, 0.02}, .radius = 0.03}};
  const DirectionPair low = ToDirections({.theta_h = 0, .theta_d = RadFromDeg(82), .phi_d = 0});
  const PathPlanner paths(rig);
  const AxisPositions from = {1.2, 1.9, 0.1};
  const auto path = paths.PlanTo(from, low);
  ASSERT_TRUE(path.ok()) << path.error().message;
  EXPECT_GT(std::abs(path->back()[turntable::kSampleTurn]), RadFromDeg(25));
  rig.axes[turntable::kSampleTurn].min_position = -0.1;
  rig.axes[turntable::kSampleTurn].max_position = 0.2;
  EXPECT_FALSE(PathPlanner(rig).PlanTo(from, low).ok());
}

TEST(Turntable, ArmsDoNotPassEachOther) {
  const RigConfig rig = RigOf(kEveryKind[1]);
  const PathPlanner paths(rig);
  const auto crossed =
      paths.Plan({RadFromDeg(40), RadFromDeg(120)}, {RadFromDeg(120), RadFromDeg(40)});
  ASSERT_FALSE(crossed.ok());
  EXPECT_THAT(crossed.error().message, HasSubstr("no way around"));
  // The same pair for an isotropic sample is there without that.
  const auto mirrored = paths.PlanTo({RadFromDeg(40), RadFromDeg(120)},
                                     Kinematics(rig).Forward({RadFromDeg(120), RadFromDeg(40)}));
  EXPECT_TRUE(mirrored.ok());
}

// ---- the tilting sample

const KindOfRig& kTilting = kEveryKind[2];

TEST(TiltingSample, FacesTheLightWithAllAxesAtZero) {
  const Kinematics kinematics(RigOf(kTilting));
  EXPECT_LT((kinematics.Forward({}).wi - Eigen::Vector3d::UnitZ()).norm(), 1e-12);
  // The camera a quarter round from it, the sample half way between them: the mirror's direction.
  const DirectionPair mirror = kinematics.Forward({RadFromDeg(90), RadFromDeg(45)});
  EXPECT_NEAR(ToHalfDiff(mirror).theta_h, 0, 1e-7);
  EXPECT_NEAR(ToHalfDiff(mirror).theta_d, RadFromDeg(45), 1e-9);
  // The normal tipped up out of the plane of the two, which then stand below it.
  const HalfDiff tipped = ToHalfDiff(kinematics.Forward({RadFromDeg(90), RadFromDeg(45), 0.3}));
  EXPECT_NEAR(tipped.theta_h, 0.3, 1e-9);
  EXPECT_NEAR(tipped.phi_d, kPi / 2, 1e-9);
}

// Across the plane theta_h is the tilt itself.
TEST(TiltingSample, ReachesAcrossAsFarAsItTilts) {
  const Kinematics kinematics(RigOf(kTilting));
  EXPECT_TRUE(kinematics.Reachable(PairAt(74, 5, 90)));
  EXPECT_FALSE(kinematics.Reachable(PairAt(76, 5, 90)));
  EXPECT_TRUE(kinematics.Reachable(PairAt(76, 5, 10)));
}

TEST(TiltingSample, HasFourSolutionsAndLeavesTheAzimuth) {
  RigConfig rig = RigOf(kTilting);
  rig.keep_out = {};  // nothing turns that could be in the way
  const auto solutions = Kinematics(rig).Solutions(PairAt(20, 40, 60), {0.1, 0.2, 0.3, 0.7});
  EXPECT_EQ(solutions.size(), 4u);
  for (const AxisPositions& at : solutions) EXPECT_EQ(at[tilting_sample::kSampleAzimuth], 0.7);
}

TEST(TiltingSample, GoesWithoutAnAzimuth) {
  std::string text = TextOf(kTilting);
  const auto begin = text.find("  sample_azimuth:");
  text.erase(begin, text.find("\n#", begin) - begin);
  const auto order = text.find(", sample_azimuth]");
  text.erase(order, std::string(", sample_azimuth").size());
  const ConfigNode root = ConfigNode::Parse(text, "rig.yaml");
  const RigConfig rig = ReadRig(root, text);
  const SimConfig truth = ReadSim(root);
  root.RefuseUnknownKeys();
  EXPECT_EQ(rig.axis_count, 3);
  EXPECT_EQ(rig.axis_names().back(), std::string("sample_tilt"));
  EXPECT_TRUE(Kinematics(rig).Reachable(PairAt(20, 40, 60)));
  const FlatBrdf grey(Rgb::Constant(0.2));
  SimulatedRig bench(grey, 1, rig, truth);
  PoseMeasurer measurer = bench.Prepared();
  const auto pose = measurer.Measure(PairAt(20, 40, 60), std::nullopt, {});
  ASSERT_TRUE(pose.ok()) << pose.error().message;
  EXPECT_EQ(pose->readback[tilting_sample::kSampleAzimuth], 0);
}

// ---- rig files

std::string ComplaintAbout(const KindOfRig& kind, const std::string& from, const std::string& to) {
  std::string text = TextOf(kind);
  const auto at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  text.replace(at, from.size(), to);
  try {
    const ConfigNode root = ConfigNode::Parse(text, "rig.yaml");
    ReadRig(root, text);
    ReadSim(root);
    root.RefuseUnknownKeys();
  } catch (const ConfigError& e) {
    const std::string message = e.what();  // without the line, which moves with every comment
    return message.substr(message.find(": ") + 2);
  }
  return "none";
}

TEST(ReadTurntable, RefusesWhatItHasNot) {
  const KindOfRig& kind = kEveryKind[1];
  EXPECT_EQ(ComplaintAbout(kind, "kind: turntable", "kind: turntable"), "none");
  EXPECT_EQ(ComplaintAbout(kind, "  camera_arm:", "  camera_elevation:"),
            "axes.camera_arm: is missing");
  EXPECT_EQ(ComplaintAbout(kind, "  sample_turn:", "  light_azimuth: {}\n  sample_turn:"),
            "axes.light_azimuth: is not a known key");
  EXPECT_EQ(ComplaintAbout(kind, "max_deg: 178", "max_deg: 181"),
            "axes.light_arm.max_deg: is 181, must be between 0 and 180");
  EXPECT_EQ(ComplaintAbout(kind, "home_order: [light_arm,", "home_order: [light_azimuth,"),
            "motion.home_order: must name each of light_arm, camera_arm, sample_turn once");
  EXPECT_EQ(ComplaintAbout(kind, "radius_mm: 30}", "radius_mm: 30, turns_with: azimuth}"),
            "keep_out.light_arm[0].turns_with: is not a known key");
  EXPECT_THAT(
      ComplaintAbout(kind, "margin_mm: 10", "margin_mm: 10\n  max_azimuth_difference_deg: 9"),
      HasSubstr("keep_out.max_azimuth_difference_deg: arms without azimuths wind no cables"));
  EXPECT_THAT(ComplaintAbout(kind, "motion:",
                             "drift: {every_poses: 5, pose: {theta_h_deg: 5, theta_d_deg: "
                             "30, phi_d_deg: 90}}\nmotion:"),
              HasSubstr("drift.pose.phi_d_deg: must be 0 or 180"));
  EXPECT_EQ(ComplaintAbout(kind, "simulation:", "simulation:\n  axis_offset_deg: [1, 1, 1, 1]"),
            "simulation.axis_offset_deg: must be a list of 3 numbers");
}

TEST(ReadTiltingSample, RefusesWhatItHasNot) {
  EXPECT_EQ(ComplaintAbout(kTilting, "kind: tilting-sample", "kind: tilting-sample"), "none");
  EXPECT_EQ(ComplaintAbout(kTilting, "  sample_tilt:", "  sample_tip:"),
            "axes.sample_tilt: is missing");
  EXPECT_EQ(ComplaintAbout(kTilting, "max_deg: 75", "max_deg: 95"),
            "axes.sample_tilt.max_deg: is 95, must be between -90 and 90");
  EXPECT_EQ(ComplaintAbout(kTilting, "keep_out:", "keep_out:\n  light_arm: []"),
            "keep_out.light_arm: the light of a rig of kind tilting-sample stands still: put it "
            "under fixed");
  EXPECT_EQ(ComplaintAbout(kTilting, "turns_with: tilt", "turns_with: elevation"),
            "keep_out.sample[1].turns_with: is \"elevation\", must be one of turn, tilt, azimuth");
}

TEST(ReadFourAxisArms, AreWhatIsMeantWithoutAKindAndByTheOldName) {
  for (const char* kind : {"", "  kind: four-axis\n"}) {
    EXPECT_EQ(ComplaintAbout(kEveryKind[0], "  kind: four-axis-arms\n", kind), "none");
  }
  EXPECT_THAT(
      ComplaintAbout(kEveryKind[0], "motion:", "keep_out: {margin_mm: 5, sample: []}\nmotion:"),
      HasSubstr("keep_out.sample: the sample of a rig of four-axis-arms stands still"));
}

}  // namespace
}  // namespace gonio
