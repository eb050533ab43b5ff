// SPDX-License-Identifier: Apache-2.0
#include "planner/slice_refinement_planner.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "brdf/metrics.h"
#include "core/units.h"
#include "fitting/scattered_reflectance.h"
#include "planner/sequence_planner.h"
#include "tests/fitting/training_set.h"

namespace gonio {
namespace {

const std::vector<Candidate>& Raster() {
  static const auto candidates = MakeCandidates({}, {});
  return candidates;
}

BrdfSample Read(const Brdf& material, const DirectionPair& pair) {
  const Rgb f_r = *material.Eval(pair);
  return {.directions = pair, .f_r = f_r, .sigma = 0.01 * f_r};
}

std::vector<BrdfSample> Scan(const Brdf& material, SliceRefinementPlanner& planner) {
  std::vector<BrdfSample> samples;
  while (const auto next = planner.Next()) {
    samples.push_back(Read(material, next->directions));
    planner.Observe(*next, samples.back());
  }
  return samples;
}

TEST(SliceRefinementPlanner, BeginsWithThePeakTheBaseAndTheShoulder) {
  SliceRefinementPlanner planner(Raster(), {.max_poses = 3});
  const auto samples = Scan(*PeakedMaterial(0.1, 1, 0.2), planner);
  ASSERT_EQ(samples.size(), 3);
  EXPECT_NEAR(DegFromRad(ToHalfDiff(samples[0].directions).theta_h), 0.1, 0.1);
  EXPECT_NEAR(DegFromRad(ToHalfDiff(samples[1].directions).theta_h), 32, 1);
  EXPECT_NEAR(DegFromRad(ToHalfDiff(samples[2].directions).theta_h), 8, 1);
  EXPECT_EQ(planner.reason(), "pose budget reached");
}

// A plateau that ends at theta_h = 20 deg: two thirds of the later poses belong to its edge.
TEST(SliceRefinementPlanner, LooksWhereTheReflectanceBends) {
  const FunctionBrdf edge([](const HalfDiff& a) {
    return Rgb::Constant(0.1 + 5 / (1 + std::exp((DegFromRad(a.theta_h) - 20) / 1.5)));
  });
  SliceRefinementPlanner planner(Raster(), {.max_poses = 72});
  const auto samples = Scan(edge, planner);
  int near = 0;
  for (std::size_t n = 12; n < samples.size(); ++n) {
    const double theta_h = DegFromRad(ToHalfDiff(samples[n].directions).theta_h);
    near += theta_h > 12 && theta_h < 32;  // 22 % of the raster's rows
  }
  EXPECT_GT(near, 30);
}

TEST(SliceRefinementPlanner, BeatsRandomPosesWithTheSameReconstruction) {
  const auto material = PeakedMaterial(0.1, 20, 0.1);
  constexpr int kPoses = 40;
  SliceRefinementPlanner planner(Raster(), {.max_poses = kPoses});
  const auto adaptive = InterpolateScattered(Scan(*material, planner));
  const MetricOptions metric{.phi_stride = 30};
  double random = 0;
  for (int seed = 0; seed < 3; ++seed) {
    std::vector<BrdfSample> samples;
    for (const int i : RandomOrder(Raster().size(), kPoses, seed)) {
      samples.push_back(Read(*material, Raster()[i].directions));
    }
    random += Compare(*material, *InterpolateScattered(samples), metric).male / 3;
  }
  EXPECT_LT(Compare(*material, *adaptive, metric).male, 0.5 * random);
}

TEST(SliceRefinementPlanner, IsNotLedByReadingsWithoutMeaning) {
  SliceRefinementPlanner planner(Raster(), {.max_poses = 60});
  int count = 0;
  while (const auto next = planner.Next()) {
    planner.Observe(*next, {.directions = next->directions,
                            .f_r = Rgb::Constant(std::numeric_limits<double>::quiet_NaN()),
                            .sigma = Rgb::Constant(std::numeric_limits<double>::infinity())});
    EXPECT_TRUE(std::isfinite(next->score));
    ++count;
  }
  EXPECT_EQ(count, 60);
}

TEST(SliceRefinementPlanner, GoesOnUntilEveryCandidateIsMeasured) {
  const auto few = MakeCandidates({.theta_h_count = 9, .theta_d_count = 7}, {});
  SliceRefinementPlanner planner(few, {});
  EXPECT_EQ(Scan(*PeakedMaterial(0.1, 20, 0.1), planner).size(), few.size());
  EXPECT_EQ(planner.MaxPoses(), static_cast<int>(few.size()));
}

}  // namespace
}  // namespace gonio
