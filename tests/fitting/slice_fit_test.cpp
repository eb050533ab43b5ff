// SPDX-License-Identifier: Apache-2.0
// One slice, fitted by expectation maximisation and jointly.

#include "fitting/slice_fit.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "brdf/merl_table.h"
#include "core/units.h"
#include "fitting/hemi_epd.h"
#include "fitting/slice_em.h"
#include "fitting/slice_joint.h"

namespace gonio {
namespace {

using testing::HasSubstr;

double Sum(const std::vector<Lobe>& lobes, double theta_h) {
  double f_r = 0;
  for (const Lobe& lobe : lobes) f_r += EvalLobe(lobe, LogCos(theta_h));
  return f_r;
}

// A slice at theta_d whose readings are exactly these lobes.
std::vector<SlicePoint> Readings(const std::vector<Lobe>& lobes, double theta_d = 0.3) {
  std::vector<SlicePoint> points;
  for (int h = 0; h < MerlTable::kThetaH; ++h) {
    const double theta_h = MerlTable::CellCentre(h, 0, 0).theta_h;
    points.push_back({theta_h, MerlTable::ThetaHWidth(h), Sum(lobes, theta_h),
                      std::cos(theta_d) * std::cos(theta_h), 180});
  }
  return points;
}

double WorstLogError(const std::vector<SlicePoint>& points, const std::vector<Lobe>& lobes) {
  double worst = 0;
  for (const SlicePoint& p : points) {
    worst = std::max(worst, std::abs(std::log1p(p.cos_theta_i * p.f_r) -
                                     std::log1p(p.cos_theta_i * Sum(lobes, p.theta_h))));
  }
  return worst;
}

const std::vector<Lobe> kThree = {{0.12, 0.4}, {0.5, 25}, {1.8, 900}};

TEST(SliceFit, SaysWhyASliceCannotBeFitted) {
  const auto why = [](std::vector<SlicePoint> points) {
    return WhyNotFittable(points, 3).value_or("");
  };
  std::vector<SlicePoint> points = Readings(kThree);
  EXPECT_EQ(why(points), "");
  EXPECT_EQ(why({}), "holds no reading");
  std::vector<SlicePoint> few(points.begin(), points.begin() + 5);
  EXPECT_EQ(why(few), "5 valid readings for the 6 parameters of 3 lobes");
  std::vector<SlicePoint> invalid = points;
  for (SlicePoint& point : invalid) point.cells = 0;
  EXPECT_EQ(why(invalid), "no reading is valid");
  std::vector<SlicePoint> dark = points;
  for (SlicePoint& point : dark) point.f_r = 0;
  EXPECT_EQ(why(dark), "every reading is zero");
  points[20].f_r = -0.04 * points[0].f_r;  // noise, or a colour out of gamut
  EXPECT_EQ(why(points), "");
  points[20].f_r = -0.06 * points[0].f_r;
  EXPECT_THAT(why(points), HasSubstr("negative"));
}

TEST(SliceFit, KnowsAConstant) {
  std::vector<SlicePoint> points = Readings(kThree);
  EXPECT_FALSE(IsConstant(points));
  for (SlicePoint& point : points) point.f_r = 0.3;
  EXPECT_TRUE(IsConstant(points));
}

TEST(SliceFit, StartsFromBroadToNarrow) {
  const std::vector<Lobe> start = StartingLobes(Readings(kThree), 3, 200);
  ASSERT_EQ(start.size(), 3u);
  EXPECT_LT(start[0].gamma, start[1].gamma);
  EXPECT_NEAR(start[2].gamma, 200, 1e-9);
  EXPECT_NEAR(std::expm1(start[2].kappa), Sum(kThree, 0), 0.05 * Sum(kThree, 0));
}

TEST(SliceEm, FitsASingleLobeExactly) {
  const std::vector<Lobe> one = {{0.8, 40}};
  const SliceFit fit = FitSliceEm(Readings(one), {.lobes = 1});
  EXPECT_TRUE(fit.converged);
  EXPECT_NEAR(fit.lobes[0].kappa, 0.8, 1e-4);
  EXPECT_NEAR(fit.lobes[0].gamma, 40, 0.02);
  EXPECT_LT(fit.cost, 1e-6);
}

TEST(SliceEm, SplitsPeakAndDiffusePart) {
  const SliceFit fit = FitSliceEm(Readings(kThree));
  ASSERT_EQ(fit.lobes.size(), 3u);
  EXPECT_NEAR(Sum(fit.lobes, 0), Sum(kThree, 0), 0.1 * Sum(kThree, 0));
  EXPECT_NEAR(Sum(fit.lobes, 1.0), Sum(kThree, 1.0), 0.2 * Sum(kThree, 1.0));
}

TEST(SliceEm, ReportsItsIterationLimit) {
  const SliceFit fit = FitSliceEm(Readings(kThree), {.max_iterations = 2});
  EXPECT_FALSE(fit.converged);
  EXPECT_EQ(fit.iterations, 2);
  EXPECT_EQ(fit.reason, "limit of 2 iterations");
}

TEST(SliceEm, StaysFiniteOnExtremeReadings) {
  for (const double scale : {1e-6, 1e5}) {
    std::vector<SlicePoint> points = Readings(kThree);
    for (SlicePoint& point : points) point.f_r *= scale;
    const SliceFit fit = FitSliceEm(points);
    for (const Lobe& lobe : fit.lobes) {
      EXPECT_TRUE(std::isfinite(lobe.kappa) && lobe.kappa > 0);
      EXPECT_TRUE(std::isfinite(lobe.gamma) && lobe.gamma > 0);
    }
    EXPECT_TRUE(std::isfinite(fit.cost));
  }
}

TEST(SliceJoint, RecoversThreeLobes) {
  const std::vector<std::vector<SlicePoint>> slices = {Readings(kThree)};
  const SliceFit fit = FitSlicesJoint(slices)[0];
  EXPECT_TRUE(fit.converged);
  for (int k = 0; k < 3; ++k) {
    EXPECT_NEAR(fit.lobes[k].kappa, kThree[k].kappa, 0.02 * kThree[k].kappa) << k;
    EXPECT_NEAR(fit.lobes[k].gamma, kThree[k].gamma, 0.02 * kThree[k].gamma) << k;
  }
}

TEST(SliceJoint, IsNearerThanEmForAnyNumberOfLobes) {
  // A shape outside the family: a Lorentzian peak.
  std::vector<SlicePoint> points = Readings(kThree);
  for (SlicePoint& p : points) p.f_r = 0.1 + 5 / (1 + std::pow(p.theta_h / 0.05, 2));
  const std::vector<std::vector<SlicePoint>> slices = {points};
  double before = 1e9;
  for (int lobes = 1; lobes <= 5; ++lobes) {
    const SliceFit joint = FitSlicesJoint(slices, {.lobes = lobes})[0];
    ASSERT_EQ(static_cast<int>(joint.lobes.size()), lobes);
    EXPECT_LT(joint.cost, 1.001 * before) << lobes;
    before = joint.cost;
  }
  EXPECT_LT(WorstLogError(points, FitSlicesJoint(slices)[0].lobes),
            WorstLogError(points, FitSliceEm(points).lobes));
}

// Lobes that change smoothly over theta_d must not swap their places.
TEST(SliceJoint, KeepsLobesInTheirPlacesAlongTheSlices) {
  std::vector<std::vector<SlicePoint>> slices;
  for (int i = 0; i < 12; ++i) {
    const double t = i / 11.0;
    slices.push_back(Readings(
        {{0.1 + 0.05 * t, 0.4}, {0.5 - 0.2 * t, 12 + 20 * t}, {0.6 + t, 300 + 500 * t}}, 0.1 * i));
  }
  const std::vector<SliceFit> fits = FitSlicesJoint(slices);
  for (std::size_t i = 0; i + 1 < fits.size(); ++i) {
    for (int k = 0; k < 3; ++k) {
      EXPECT_LT(std::abs(std::log(fits[i + 1].lobes[k].gamma / fits[i].lobes[k].gamma)), 0.5)
          << "slice " << i << ", lobe " << k;
    }
  }
}

// A mirror leaves most lobes nothing to do: their parameters stop to matter, and must not end up
// anywhere.
TEST(SliceJoint, StaysFiniteWhereLobesHaveNothingToDo) {
  std::vector<std::vector<SlicePoint>> slices;
  for (int i = 0; i < 8; ++i) {
    slices.push_back(Readings({{0.02, 170.0 / (i + 1)}, {6.0 + i, 4e4}}, 0.2 * i));
  }
  for (int lobes = 1; lobes <= 5; ++lobes) {
    for (const SliceFit& fit : FitSlicesJoint(slices, {.lobes = lobes})) {
      EXPECT_TRUE(std::isfinite(fit.cost));
      for (const Lobe& lobe : fit.lobes) {
        EXPECT_TRUE(std::isfinite(lobe.kappa) && lobe.kappa > 0) << lobes;
        EXPECT_TRUE(std::isfinite(lobe.gamma) && lobe.gamma > 0) << lobes;
      }
    }
  }
}

TEST(SliceJoint, GivesTheSameAgain) {
  const std::vector<std::vector<SlicePoint>> slices = {Readings(kThree), Readings(kThree, 0.4)};
  EXPECT_EQ(FitSlicesJoint(slices)[1].cost, FitSlicesJoint(slices)[1].cost);
}

}  // namespace
}  // namespace gonio
