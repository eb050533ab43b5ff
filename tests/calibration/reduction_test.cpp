// SPDX-License-Identifier: Apache-2.0
// From counts of a camera with imperfections to f_r, with its calibration.

#include <gmock/gmock.h>

#include <cmath>

#include "acquisition/radiometry.h"
#include "sim/random.h"
#include "tests/calibration/imperfect_rig.h"

namespace gonio {
namespace {

// Calibrations that say what the rig says: a dark current, and nothing else.
Calibrations NothingNew(const RigConfig& rig, const Camera& camera) {
  Calibrations same;
  same.format = SensorFormatOf(rig, camera.identity());
  same.sensor = SensorCalibration{{rig.radiometry.electrons_per_count, 0},
                                  {rig.radiometry.read_noise, 0},
                                  {20000, 0},
                                  {0, 0},
                                  Linearity::Identity(rig.camera.full_scale)};
  same.files.push_back({});
  return same;
}

// The two ways of Reduce(): by means of counts, by sites. Example failure: a monitor or a cosine
// that one of them forgets, or a random term of twice its size.
TEST(ReduceWithCalibrations, GivesWhatTheRigGivesWhereTheySayTheSame) {
  const FlatBrdf sample(Rgb(0.3, 0.05, 0.002));
  SimulatedRig rig(sample, 3);
  PoseMeasurer measurer = rig.Prepared();
  const auto record = measurer.Measure(PairAt(25, 30, 60), std::nullopt, {}, 2);
  ASSERT_TRUE(record.ok());
  const Calibrations same = NothingNew(rig.rig, *rig.devices.camera);
  const auto by_rig = Reduce(*record, rig.rig, Calibrations{});
  const auto by_sites = Reduce(*record, rig.rig, same);
  ASSERT_TRUE(by_rig.ok() && by_sites.ok());
  const BrdfSample& a = by_rig->front().sample;
  const BrdfSample& b = by_sites->front().sample;
  for (int c = 0; c < kChannels; ++c) {
    EXPECT_NEAR(b.f_r[c], a.f_r[c], 0.1 * a.sigma[c]) << c;
    EXPECT_NEAR(b.sigma[c] / a.sigma[c], 1, 0.02) << c;
    // The budget's random terms are what sigma is.
    EXPECT_NEAR(by_rig->front().budget.random()[c] / a.sigma[c], 1, 1e-9) << c;
    EXPECT_NEAR(by_sites->front().budget.random()[c] / b.sigma[c], 1, 1e-9) << c;
  }
}

TEST(ReduceWithCalibrations, RefusesFramesThatTheDarksDoNotReach) {
  SimulatedRig rig(WhiteTile(), 1, ImperfectRig(), ImperfectTruth());
  PoseMeasurer measurer = rig.Prepared();
  auto record = measurer.Measure(PairAt(25, 30, 60), std::nullopt, {});
  ASSERT_TRUE(record.ok());
  record->exposures.front().frame.exposure = Seconds(100);
  const auto reduced = Reduce(*record, rig.rig, LoadFrom(CalibratedFolder()));
  ASSERT_FALSE(reduced.ok());
  EXPECT_THAT(reduced.error().message, testing::HasSubstr("longest"));
}

TEST(ReduceWithCalibrations, KnowsNothingOfSaturatedChannels) {
  SimulatedRig rig(WhiteTile(), 1, ImperfectRig(), ImperfectTruth());
  PoseMeasurer measurer = rig.Prepared();
  auto record = measurer.Measure(PairAt(25, 30, 60), std::nullopt, {});
  ASSERT_TRUE(record.ok());
  for (Exposure& e : record->exposures) {
    for (std::size_t i = 0; i < e.frame.counts.size(); i += 3) e.frame.counts[i] = 4095;
  }
  const auto reduced = Reduce(*record, rig.rig, LoadFrom(CalibratedFolder()));
  ASSERT_TRUE(reduced.ok());
  EXPECT_TRUE(std::isinf(reduced->front().sample.sigma[0]));
  EXPECT_TRUE(std::isfinite(reduced->front().sample.sigma[1]));
}

// Where all pixels see the same, glare only moves light about: what it adds it has taken. The
// background is per pixel, whatever light falls on the sample. Example failure: a background that
// is divided by cos(theta_i) twice.
TEST(ReduceWithCalibrations, TakesOffStrayLight) {
  const FlatBrdf sample(Rgb(0.3, 0.05, 0.02));
  SimulatedRig rig(sample, 3);
  PoseMeasurer measurer = rig.Prepared();
  const auto record = measurer.Measure(PairAt(25, 30, 60), std::nullopt, {}, 2);
  ASSERT_TRUE(record.ok());
  Calibrations calibrations = NothingNew(rig.rig, *rig.devices.camera);
  const auto without = Reduce(*record, rig.rig, calibrations);
  StrayLight stray;
  stray.background = {90, 3};
  stray.glare = {0.1, 0.02};
  calibrations.stray = StrayLights{stray, stray, stray};
  const auto with = Reduce(*record, rig.rig, calibrations);
  ASSERT_TRUE(with.ok() && without.ok());
  const BrdfSample& a = without->front().sample;
  const BrdfSample& b = with->front().sample;
  for (int c = 0; c < kChannels; ++c) {
    const double per_f_r = rig.rig.radiometry.responsivity[c] * record->regions.front().light;
    EXPECT_NEAR(b.f_r[c], a.f_r[c] - 90 / per_f_r, 1e-3 * a.f_r[c]) << c;
    EXPECT_NEAR(with->front().budget[UncertaintyTerm::kStrayLight][c], 3 / per_f_r,
                0.05 * 3 / per_f_r)
        << c;
  }
}

// A session can be reduced again from what lies in it.
TEST(ReduceWithCalibrations, GivesTheSameToTheLastBitFromCopies) {
  SimulatedRig rig(WhiteTile(), 1, ImperfectRig(), ImperfectTruth());
  PoseMeasurer measurer = rig.Prepared();
  const auto record = measurer.Measure(PairAt(25, 30, 60), std::nullopt, {});
  ASSERT_TRUE(record.ok());
  const Calibrations used = LoadFrom(CalibratedFolder());
  const TempDir dir;
  CopyCalibrations(used, dir.path() / "calibration");
  const auto first = Reduce(*record, rig.rig, used);
  const auto again = Reduce(*record, rig.rig, LoadCopies(dir.path() / "calibration"));
  ASSERT_TRUE(first.ok() && again.ok());
  EXPECT_TRUE((first->front().sample.f_r == again->front().sample.f_r).all());
  EXPECT_TRUE((first->front().sample.sigma == again->front().sample.sigma).all());
  EXPECT_TRUE(LoadCopies(dir.path() / "none").empty());
}

struct Measured {
  Rgb f_r;
  Rgb random;
  Rgb systematic;
};

Measured Measure(const Rgb& truth, std::uint64_t seed, const Calibrations& calibrations) {
  const FlatBrdf sample(truth);
  RigConfig config = ImperfectRig();
  Believe(calibrations, &config);
  SimulatedRig rig(sample, seed, config, ImperfectTruth());
  PoseMeasurer measurer(rig.rig, rig.devices, rig.clock,
                        calibrations.bad_pixels ? &calibrations.bad_pixels->mask : nullptr);
  EXPECT_TRUE(measurer.Prepare({}).ok());
  const auto record = measurer.Measure(PairAt(25, 30, 60), std::nullopt, {});
  EXPECT_TRUE(record.ok());
  const auto reduced = Reduce(*record, rig.rig, calibrations);
  EXPECT_TRUE(reduced.ok());
  return {reduced->front().sample.f_r, reduced->front().sample.sigma,
          reduced->front().budget.systematic()};
}

// Over three decades the calibrated chain is right within what it states, and without its files it
// is not. Example failure: stray light that is taken off per unit of light instead of per pixel.
TEST(ReduceWithCalibrations, IsTrueWithinItsBudget) {
  const Calibrations calibrations = LoadFrom(CalibratedFolder());
  const Calibrations none;
  for (const double f_r : {0.01, 0.3, 10.0}) {
    constexpr int kSeeds = 12;
    Rgb mean = Rgb::Zero();
    Rgb mean_without = Rgb::Zero();
    Rgb stated = Rgb::Zero();
    for (int seed = 0; seed < kSeeds; ++seed) {
      const auto one =
          Measure(Rgb::Constant(f_r), 100 + static_cast<std::uint64_t>(seed), calibrations);
      mean += one.f_r / kSeeds;
      mean_without +=
          Measure(Rgb::Constant(f_r), 100 + static_cast<std::uint64_t>(seed), none).f_r / kSeeds;
      stated = (one.random.square() / kSeeds + one.systematic.square()).sqrt();
    }
    for (int c = 0; c < kChannels; ++c) {
      EXPECT_LT(std::abs(mean[c] - f_r), 3.5 * stated[c]) << f_r << " " << c;
      EXPECT_GT(std::abs(mean_without[c] - f_r), 4 * stated[c]) << f_r << " " << c;
    }
  }
}

}  // namespace
}  // namespace gonio
