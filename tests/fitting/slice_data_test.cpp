// SPDX-License-Identifier: Apache-2.0
#include "fitting/slice_data.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "core/error.h"
#include "tests/brdf/function_brdf.h"
#include "tests/core/temp_dir.h"

namespace gonio {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

TEST(SliceData, TakesEighteenSlicesFiveDegreesApart) {
  const FunctionBrdf brdf([](const HalfDiff&) { return Rgb::Constant(1); });
  const std::vector<SliceData> slices = SlicesOf(brdf, {});
  ASSERT_EQ(slices.size(), 18u);
  EXPECT_NEAR(DegFromRad(slices[0].theta_d), 0.5, 1e-9);
  EXPECT_NEAR(DegFromRad(slices[17].theta_d), 85.5, 1e-9);
  EXPECT_EQ(slices[0].points[0].size(), 90u);
  EXPECT_EQ(SlicesOf(brdf, {.step = RadFromDeg(1)}).size(), 90u);
}

TEST(SliceData, AveragesOverTheDirectionsAboveTheHorizon) {
  // phi_d itself: symmetric about 90 degrees, as is the part of a cell row above the horizon.
  const FunctionBrdf brdf([](const HalfDiff& x) { return Rgb(x.phi_d, x.theta_h, x.theta_d); });
  const SliceData slice = SliceAt(brdf, 60, {});
  for (int h = 0; h < 90; h += 10) {
    const SlicePoint& point = slice.points[0][h];
    ASSERT_GT(point.cells, 0);
    EXPECT_NEAR(point.f_r, kPi / 2, 1e-9);
    EXPECT_NEAR(slice.points[1][h].f_r, point.theta_h, 1e-12);
    EXPECT_NEAR(slice.points[2][h].f_r, slice.theta_d, 1e-12);
    EXPECT_NEAR(point.cos_theta_i, std::cos(slice.theta_d) * std::cos(point.theta_h), 1e-9);
  }
  EXPECT_EQ(slice.points[0][0].cells, 180);
  EXPECT_LT(slice.points[0][80].cells, 90);  // near the horizon only some phi_d are possible
}

TEST(SliceData, KeepsEveryNthThetaH) {
  const FunctionBrdf brdf([](const HalfDiff& x) { return Rgb::Constant(x.theta_h); });
  const SliceData all = SliceAt(brdf, 0, {});
  const SliceData some = SliceAt(brdf, 0, {.keep_every = 11});
  ASSERT_EQ(some.points[1].size(), 9u);
  for (std::size_t i = 0; i < 9; ++i) {
    EXPECT_EQ(some.points[1][i].theta_h, all.points[1][11 * i].theta_h);
  }
}

TEST(SliceData, CountsUnknownCellsOfEachChannelAlone) {
  const FunctionBrdf brdf([](const HalfDiff& x) -> std::optional<Rgb> {
    if (x.theta_h > 1) return std::nullopt;
    return Rgb(1, kNan, x.phi_d < kPi / 2 ? 2 : kNan);
  });
  const SliceData slice = SliceAt(brdf, 0, {});
  EXPECT_EQ(slice.points[0][0].cells, 180);
  EXPECT_EQ(slice.points[1][0].cells, 0);
  EXPECT_EQ(slice.points[2][0].cells, 90);
  EXPECT_EQ(slice.points[2][0].f_r, 2);
  EXPECT_EQ(slice.points[0][89].cells, 0);
}

TEST(SliceData, PutsScatteredSamplesIntoTheNearestSlice) {
  std::vector<BrdfSample> samples;
  for (const double theta_d_deg : {1.0, 2.4, 2.6, 11.0}) {
    BrdfSample sample;
    sample.directions = ToDirections({0.3, RadFromDeg(theta_d_deg), 1.2});
    sample.f_r = Rgb(1, 2, 3);
    sample.sigma = Rgb(0.1, 0.1, std::numeric_limits<double>::infinity());
    samples.push_back(sample);
  }
  const std::vector<SliceData> slices = SlicesOf(samples, {});
  ASSERT_EQ(slices.size(), 3u);
  EXPECT_EQ(slices[0].points[0].size(), 2u);
  EXPECT_NEAR(slices[1].theta_d, RadFromDeg(5), 1e-12);
  EXPECT_EQ(slices[2].points[0].size(), 1u);
  EXPECT_EQ(slices[0].points[1][0].f_r, 2);
  EXPECT_EQ(slices[0].points[2][0].cells, 0);  // its sigma is infinite
  EXPECT_THROW(SlicesOf(samples, {.keep_every = 2}), ConfigError);
}

TEST(SliceData, RefusesOptionsOutOfRange) {
  const auto message = [](SliceOptions options) {
    return MessageOf<ConfigError>([&] { options.Check(); });
  };
  EXPECT_EQ(message({.step = 0}), "slice_step_deg: is 0, must be between 1 and 30");
  EXPECT_EQ(message({.keep_every = 91}), "keep_every: is 91, must be between 1 and 90");
  EXPECT_EQ(message({.phi_stride = 0}), "phi_stride: is 0, must be between 1 and 180");
}

}  // namespace
}  // namespace gonio
