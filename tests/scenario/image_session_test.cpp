// SPDX-License-Identifier: Apache-2.0
// Images of which each pixel has its own directions, from the simulated lens to the samples. The
// simulation and the reduction have each their own geometry.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "acquisition/radiometry.h"
#include "acquisition/session_record.h"
#include "tests/acquisition/simulated_rig.h"
#include "tests/core/temp_dir.h"
#include "tests/scenario/bench.h"

namespace gonio {
namespace {

AnalyticBrdf Paint() {
  return AnalyticBrdf("paint", {Lambert{{0.3, 0.2, 0.1}}, Ggx{.roughness = 0.5, .ior = 1.5}});
}

RigConfig ImagingRig(SampleShape::Kind kind, int samples_per_image) {
  RigConfig rig = DefaultRig();
  rig.camera.width = rig.camera.height = 96;
  rig.camera.layout = PixelLayout::kBayerGr;
  rig.imaging = {.focal_length = 1500,
                 .camera_distance = 0.5,
                 .light_distance = 0.8,
                 .patch_radius = kind == SampleShape::Kind::kFlat ? 0.008 : 0.012,
                 .shape = {.kind = kind, .radius = 0.02}};
  rig.samples_per_image = samples_per_image;
  return rig;
}

class Images : public testing::TestWithParam<SampleShape::Kind> {};

// Example failure is an image that is mirrored on its way to the samples.
TEST_P(Images, GiveEachPartTheReflectanceOfItsDirections) {
  RigConfig rig = ImagingRig(GetParam(), 256);
  SimConfig truth;  // no imperfection
  truth.responsivity = rig.radiometry.responsivity;
  truth.electrons_per_count = rig.radiometry.electrons_per_count;
  rig.radiometry = {.responsivity = truth.responsivity,
                    .electrons_per_count = truth.electrons_per_count};
  const AnalyticBrdf paint = Paint();
  SimulatedRig simulated(paint, 1, rig, truth);
  PoseMeasurer measurer = simulated.Prepared();
  for (const auto& [theta_h, theta_d, phi_d] : {std::tuple{20, 30, 60}, {35, 20, 120}}) {
    const auto record = measurer.Measure(PairAt(theta_h, theta_d, phi_d), std::nullopt, {});
    ASSERT_TRUE(record.ok()) << record.error().message;
    const std::vector<BrdfSample> samples = Reduce(*record, rig);
    EXPECT_EQ(samples.size(), 256u);
    int readings = 0;
    for (const BrdfSample& sample : samples) {
      const Rgb error = sample.f_r - *paint.Eval(sample.directions);
      for (int c = 0; c < kChannels; ++c) {
        // A small part of a mosaic may be without pixels of a colour.
        if (!std::isfinite(sample.sigma[c])) continue;
        ++readings;
        EXPECT_LT(std::abs(error[c]), 0.015 * sample.f_r[c] + 4 * sample.sigma[c]);
      }
    }
    EXPECT_GT(readings, 500);
  }
}

// With noise: the stated sigma is what the readings scatter by. All parts of an image share the
// noise of its frames, so it takes many images.
TEST_P(Images, HaveStandardScores) {
  const AnalyticBrdf paint = Paint();
  const RigConfig rig = ImagingRig(GetParam(), 16);
  double sum = 0;
  double squares = 0;
  int count = 0;
  for (int seed = 0; seed < 120; ++seed) {
    SimulatedRig simulated(paint, seed, rig);
    PoseMeasurer measurer = simulated.Prepared();
    const auto record = measurer.Measure(PairAt(25, 30, 60), Rgb(0.1, 0.1, 0.05), {});
    ASSERT_TRUE(record.ok()) << record.error().message;
    const BrdfSample sample = Reduce(*record, rig).front();
    const Rgb z = (sample.f_r - *paint.Eval(sample.directions)) / sample.sigma;
    sum += z.sum();
    squares += z.square().sum();
    count += kChannels;
  }
  const double mean = sum / count;
  EXPECT_NEAR(mean, 0, 0.3);  // five times its standard error
  EXPECT_NEAR(std::sqrt(squares / count - mean * mean), 1, 0.15);
}

INSTANTIATE_TEST_SUITE_P(Shapes, Images,
                         testing::Values(SampleShape::Kind::kFlat, SampleShape::Kind::kSphere,
                                         SampleShape::Kind::kCylinder));

// One image of a sphere holds a fan of theta_h; all of it is in the log and reaches the planner.
TEST(ImageSession, KeepsEveryPartOfAnImage) {
  class Listener final : public ScriptedPlanner {
   public:
    using ScriptedPlanner::ScriptedPlanner;
    void AlsoObserve(const BrdfSample& sample) override { also.push_back(sample); }
    std::vector<BrdfSample> also;
  };
  const TempDir dir;
  const AnalyticBrdf paint = Paint();
  const RigConfig rig = ImagingRig(SampleShape::Kind::kSphere, 16);
  SimulatedRig simulated(paint, 1, rig);
  EventLog log = EventLog::Create(dir / "s", SomeInfo());
  Listener planner(FourPoses());
  const SessionSummary summary =
      RunSession({rig, simulated.devices, simulated.clock, planner, &log}, {});
  ASSERT_EQ(summary.outcome, SessionOutcome::kComplete) << summary.reason;
  EXPECT_EQ(planner.observed.size(), 4u);
  EXPECT_EQ(planner.also.size(), 4u * 15);
  const SessionRecord record = ReadSession(dir / "s");
  EXPECT_EQ(record.Samples().size(), 4u * 16);
  for (const MeasuredPose& pose : record.poses) {
    const auto by_theta_h = [](const BrdfSample& a, const BrdfSample& b) {
      return ToHalfDiff(a.directions).theta_h < ToHalfDiff(b.directions).theta_h;
    };
    const auto [low, high] =
        std::minmax_element(pose.samples.begin(), pose.samples.end(), by_theta_h);
    EXPECT_GT(ToHalfDiff(high->directions).theta_h - ToHalfDiff(low->directions).theta_h,
              RadFromDeg(20));
  }
}

}  // namespace
}  // namespace gonio
