// SPDX-License-Identifier: Apache-2.0
#include "fitting/scattered_reflectance.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

#include "core/units.h"
#include "fitting/angle_grid.h"
#include "tests/fitting/synthetic.h"
#include "tests/fitting/training_set.h"

namespace gonio {
namespace {

double Error(const Brdf& f, const Brdf& g) {
  const AngleGrid grid(30, 20, 3);
  double sum = 0;
  int count = 0;
  for (int node = 0; node < grid.size(); ++node) {
    if (!grid.Physical(node)) continue;
    sum += ((1 + *f.Eval(grid.Inside(node))) / (1 + *g.Eval(grid.Inside(node)))).log().abs().mean();
    ++count;
  }
  return sum / count;
}

TEST(InterpolateScattered, PassesThroughExactReadings) {
  const auto material = PeakedMaterial(0.1, 3, 0.3);
  const auto samples = Readings(*material, 30, 0, 4);
  const auto brdf = InterpolateScattered(samples, {.smoothing = 0});
  for (const BrdfSample& sample : samples) {
    EXPECT_NEAR(
        ((*brdf->Eval(sample.directions) + 0.1) / (sample.f_r + 0.1)).log().abs().maxCoeff(), 0,
        0.03);  // what laying it down on a grid costs
  }
}

TEST(InterpolateScattered, ErrsLessTheMoreReadingsThereAre) {
  const auto material = PeakedMaterial(0.1, 3, 0.3);
  double last = std::numeric_limits<double>::infinity();
  for (const int poses : {5, 40, 320}) {
    const double error = Error(*material, *InterpolateScattered(Readings(*material, poses, 0, 4)));
    EXPECT_LT(error, 0.6 * last) << poses;
    last = error;
  }
}

TEST(InterpolateScattered, SmoothsNoisyReadings) {
  const auto material = PeakedMaterial(0.3, 0, 0.3);
  const auto samples = Readings(*material, 200, 0.2, 4);
  const double smoothed = Error(*material, *InterpolateScattered(samples));
  const double exact = Error(*material, *InterpolateScattered(samples, {.smoothing = 0}));
  EXPECT_LT(smoothed, 0.7 * exact);
}

TEST(InterpolateScattered, OneReadingIsAConstantAndNoneIsBlack) {
  const auto material = PeakedMaterial(0.2, 0, 0.3);
  const auto one = InterpolateScattered(Readings(*material, 1, 0, 4));
  EXPECT_NEAR((*one->Eval(HalfDiff{0.7, 0.2, 1}))[0], 0.2, 1e-4);
  EXPECT_LT(InterpolateScattered({})->Eval(HalfDiff{0.7, 0.2, 1})->maxCoeff(), 1e-9);
}

TEST(InterpolateScattered, TakesRepeatedDirectionsAndLeavesOutWhatCouldNotBeMeasured) {
  const auto material = PeakedMaterial(0.2, 1, 0.3);
  auto samples = Readings(*material, 10, 0, 4);
  const double without = Error(*material, *InterpolateScattered(samples));
  samples.push_back(samples.front());
  samples.push_back(samples.front());
  samples.back().f_r = Rgb::Constant(1e5);
  samples.back().sigma = Rgb::Constant(std::numeric_limits<double>::infinity());
  EXPECT_NEAR(Error(*material, *InterpolateScattered(samples)), without, 0.01 * without);
}

}  // namespace
}  // namespace gonio
