// SPDX-License-Identifier: Apache-2.0
// A shutter that is late is found, and reckoned with.

#include <gmock/gmock.h>

#include "acquisition/bracket_check.h"
#include "acquisition/radiometry.h"
#include "tests/calibration/imperfect_rig.h"

namespace gonio {
namespace {

constexpr double kLate = 60e-6;  // s
constexpr double kBright = 400;  // 1/sr: exposed for some 0.3 ms

SimConfig LateTruth() {
  SimConfig truth = ImperfectTruth();
  truth.shutter_offset = kLate;
  return truth;
}

const Calibrations& LateCalibrations() {
  static const Calibrations calibrations = [] {
    const TempDir dir;
    CalibrateAll(dir.path() / "cal", 3, LateTruth());
    return LoadFrom(dir.path() / "cal");
  }();
  return calibrations;
}

Calibrations Believing(Calibrations calibrations) {
  calibrations.sensor->exposure_offset = {0, 0};
  return calibrations;
}

// Example failure: an offset of the mean dark, taken for one of the shutter.
TEST(ExposureOffset, IsFoundWithinItsError) {
  const MeasuredValue& late = LateCalibrations().sensor->exposure_offset;
  EXPECT_GT(late.sigma, 0.3e-6);
  EXPECT_LT(late.sigma, 5e-6);
  EXPECT_NEAR(late.value, kLate, 3.5 * late.sigma);
  // Of a camera that is on time.
  const MeasuredValue none = LoadFrom(CalibratedFolder()).sensor->exposure_offset;
  EXPECT_NEAR(none.value, 0, 3.5 * none.sigma);
}

// Nearly all of the sigma is that of the darks and of the shortest frames.
TEST(ExposureOffset, HasAnHonestSigma) {
  double squares = 0;
  constexpr int kSeeds = 10;
  for (std::uint64_t seed = 0; seed < kSeeds; ++seed) {
    const TempDir dir;
    StepOptions options;
    options.folder = dir.path();
    ASSERT_TRUE(RunStep(CalibrateDarks, Trap(), options, 100 + 2 * seed, LateTruth()).ok());
    ASSERT_TRUE(
        RunStep(CalibratePhotonTransfer, WhiteTile(), options, 101 + 2 * seed, LateTruth()).ok());
    const MeasuredValue late = LoadFrom(dir.path()).sensor->exposure_offset;
    const double z = (late.value - kLate) / late.sigma;
    squares += z * z / kSeeds;
  }
  EXPECT_GT(squares, 0.2);
  EXPECT_LT(squares, 2.2);
}

struct Session {
  explicit Session(const Calibrations& calibrations, double f_r, std::uint64_t seed)
      : sample(Rgb::Constant(f_r)), rig(sample, seed, Config(calibrations), LateTruth()) {
    PoseMeasurer measurer(rig.rig, rig.devices, rig.clock, &calibrations.bad_pixels->mask);
    EXPECT_TRUE(measurer.Prepare({}).ok());
    auto measured = measurer.Measure(PairAt(25, 30, 60), sample.Eval(HalfDiff{}), {}, 4);
    EXPECT_TRUE(measured.ok());
    record = std::move(measured).value();
  }
  static RigConfig Config(const Calibrations& calibrations) {
    RigConfig config = ImperfectRig();
    Believe(calibrations, &config);
    return config;
  }
  FlatBrdf sample;
  SimulatedRig rig;
  PoseRecord record;
};

TEST(ExposureOffset, IsReckonedWith) {
  double before = 0, after = 0, stated = 0;
  constexpr int kSeeds = 6;
  for (std::uint64_t seed = 0; seed < kSeeds; ++seed) {
    const Calibrations& known = LateCalibrations();
    const Session session(known, kBright, 40 + seed);
    const auto with = Reduce(session.record, session.rig.rig, known);
    const auto without = Reduce(session.record, session.rig.rig, Believing(known));
    ASSERT_TRUE(with.ok() && without.ok());
    after += (with->front().sample.f_r.mean() / kBright - 1) / kSeeds;
    before += (without->front().sample.f_r.mean() / kBright - 1) / kSeeds;
    const UncertaintyBudget& budget = with->front().budget;
    EXPECT_GT(budget[UncertaintyTerm::kExposureRatio][1], 0);
    EXPECT_EQ(without->front().budget[UncertaintyTerm::kExposureRatio][1], 0);
    stated = budget.systematic()[1] / kBright;
  }
  EXPECT_GT(before, 0.1);
  EXPECT_LT(std::abs(after), 3.5 * stated + 0.01);
  EXPECT_LT(stated, 0.03);
}

// Two exposures of one pose, the shorter one 5 times as bright as it should be.
TEST(BracketCheck, SeesExposuresThatDoNotAgree) {
  const Calibrations& known = LateCalibrations();
  Session session(known, kBright, 50);
  FrameTaker taker(session.rig.rig, session.rig.devices);
  ASSERT_TRUE(session.rig.devices.light->SetLevel(1).ok());
  for (const double t : {20e-6, 40e-6, 300e-6}) {
    auto taken = taker.Take(Seconds(t), *taker.ReadMonitor(), {});
    ASSERT_TRUE(taken.ok());
    session.record.exposures.push_back(std::move(taken).value());
  }
  const auto agrees = LeastAgreement(session.record, session.rig.rig, known);
  ASSERT_TRUE(agrees.ok() && agrees->has_value());
  EXPECT_LT(std::abs((*agrees)->score()), 4) << TextOf(**agrees);
  const auto believed = LeastAgreement(session.record, session.rig.rig, Believing(known));
  ASSERT_TRUE(believed.ok() && believed->has_value());
  EXPECT_GT(std::abs((*believed)->score()), 10);
  EXPECT_LT((*believed)->ratio.value, 0.5);
  EXPECT_THAT(TextOf(**believed), testing::HasSubstr("times what the exposures say"));
}

TEST(BracketCheck, HasNothingToCompareInOneExposure) {
  const Calibrations& known = LateCalibrations();
  Session session(known, kBright, 50);
  session.record.exposures.resize(1);
  const auto none = LeastAgreement(session.record, session.rig.rig, known);
  ASSERT_TRUE(none.ok());
  EXPECT_FALSE(none->has_value());
}

}  // namespace
}  // namespace gonio
