// SPDX-License-Identifier: Apache-2.0
#include "brdf/metrics.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "brdf/analytic.h"
#include "core/error.h"
#include "tests/brdf/function_brdf.h"
#include "tests/core/temp_dir.h"

namespace gonio {
namespace {

const AnalyticBrdf& Paint() {
  static const AnalyticBrdf brdf("paint",
                                 {Lambert{{0.2, 0.3, 0.4}}, Ggx{.roughness = 0.2, .ior = 1.5}});
  return brdf;
}

const AnalyticBrdf& Metal() {
  static const AnalyticBrdf brdf("metal", {Ggx{.roughness = 0.3, .f0 = {0.9, 0.7, 0.4}}});
  return brdf;
}

FunctionBrdf Constant(double f) {
  return FunctionBrdf([f](const HalfDiff&) { return Rgb::Constant(f); });
}

// f_r cos theta_i is the constant `f_r_cos`: what makes the logarithms' means closed forms.
FunctionBrdf ConstantTimesCosine(const Rgb& f_r_cos) {
  return FunctionBrdf([f_r_cos](const HalfDiff& angles) {
    double cos_i, cos_o;
    Cosines(angles, &cos_i, &cos_o);
    return Rgb(f_r_cos / cos_i);
  });
}

TEST(Compare, IsZeroForTheSameBrdf) {
  const ErrorMetrics same = Compare(Paint(), Paint());
  EXPECT_EQ(same.male, 0);
  EXPECT_EQ(same.male_per_channel.sum(), 0);
  EXPECT_EQ(same.log_relative_rms, 0);
  EXPECT_EQ(same.mse, 0);
  EXPECT_EQ(same.rms, 0);
  EXPECT_EQ(same.cube_root_rms, 0);
  EXPECT_EQ(same.log_mse, 0);
  EXPECT_EQ(same.missing, 0);
  EXPECT_GT(same.compared, 900'000);
}

TEST(Compare, IsZeroForATableOfTheSameBrdf) {
  const MerlTable table =
      MerlTable::FromFunction("paint", [](const HalfDiff& x) { return Paint().Eval(x); });
  const ErrorMetrics same = Compare(table, Paint());
  EXPECT_LT(same.male, 1e-15);
  EXPECT_LT(same.mse, 1e-25);
  EXPECT_EQ(same.missing, 0);
}

TEST(Compare, GivesClosedFormsForConstants) {
  const ErrorMetrics linear = Compare(Constant(0.5), Constant(0.2));
  EXPECT_NEAR(linear.mse, 0.09, 1e-12);
  EXPECT_NEAR(linear.rms, 0.3, 1e-12);
  const ErrorMetrics logs =
      Compare(ConstantTimesCosine(Rgb(1, 3, 7)), ConstantTimesCosine(Rgb(0, 1, 0.5)));
  EXPECT_NEAR(logs.male_per_channel[0], std::log(2), 1e-12);
  EXPECT_NEAR(logs.male_per_channel[1], std::log(2), 1e-12);
  EXPECT_NEAR(logs.male_per_channel[2], std::log(8 / 1.5), 1e-12);
  EXPECT_NEAR(logs.male, (2 * std::log(2) + std::log(8 / 1.5)) / 3, 1e-12);
  const double squares = 2 * std::pow(std::log(2), 2) + std::pow(std::log(8 / 1.5), 2);
  EXPECT_NEAR(logs.log_mse, squares / 3, 1e-12);
}

TEST(Compare, GivesTheClosedFormOfTheCubeRootMetric) {
  const ErrorMetrics metrics =
      Compare(ConstantTimesCosine(Rgb::Constant(8)), ConstantTimesCosine(Rgb::Constant(1)));
  EXPECT_NEAR(metrics.cube_root_rms, 1, 1e-12);
}

TEST(Compare, GivesTheClosedFormOfTheLogRelativeMetric) {
  const auto mapped = [](double value) {
    return FunctionBrdf([value](const HalfDiff& angles) {
      double cos_i, cos_o;
      Cosines(angles, &cos_i, &cos_o);
      return Rgb::Constant((value - 1e-3) / (cos_i * cos_o));
    });
  };
  EXPECT_NEAR(Compare(mapped(0.6), mapped(0.2)).log_relative_rms, std::log(3), 1e-12);
}

TEST(Compare, WeighsTheMaleUniformlyInAngleAndNothingElse) {
  double weights = 0, male = 0, squares = 0;
  int count = 0;
  for (int h = 0; h < MerlTable::kThetaH; ++h) {
    const double width = (std::pow((h + 1) / 90.0, 2) - std::pow(h / 90.0, 2)) * kPi / 2;
    for (int d = 0; d < MerlTable::kThetaD; ++d) {
      for (int p = 0; p < MerlTable::kPhiD; ++p) {
        const DirectionPair pair = ToDirections(MerlTable::CellCentre(h, d, p));
        const double cut = std::cos(RadFromDeg(80));
        if (pair.cos_theta_i() <= cut || pair.cos_theta_o() <= cut) continue;
        const Rgb f = *Paint().Eval(pair), g = *Metal().Eval(pair);
        const Rgb difference =
            (1 + f * pair.cos_theta_i()).log() - (1 + g * pair.cos_theta_i()).log();
        male += width * difference.abs().mean();
        weights += width;
        squares += (f - g).square().mean();
        ++count;
      }
    }
  }
  const ErrorMetrics metrics = Compare(Paint(), Metal());
  EXPECT_EQ(metrics.compared, count);
  EXPECT_NEAR(metrics.male, male / weights, 1e-10);
  EXPECT_NEAR(metrics.mse, squares / count, 1e-9 * metrics.mse);
  EXPECT_NEAR(metrics.male, metrics.male_per_channel.mean(), 1e-15);
  EXPECT_NEAR(metrics.rms * metrics.rms, metrics.mse, 1e-12 * metrics.mse);
}

TEST(Compare, LooksOnlyBelowTheGivenAngle) {
  // Wrong beyond 80 degrees, where nothing but the whole table's error looks.
  const FunctionBrdf reference = Constant(1);
  const FunctionBrdf other([](const HalfDiff& x) {
    double cos_i, cos_o;
    Cosines(x, &cos_i, &cos_o);
    return Rgb::Constant(std::min(cos_i, cos_o) < std::cos(RadFromDeg(80)) ? 3 : 1);
  });
  const ErrorMetrics below_80 = Compare(reference, other, {.phi_stride = 10});
  EXPECT_EQ(below_80.male, 0);
  EXPECT_EQ(below_80.mse, 0);
  EXPECT_GT(below_80.table_mse, 0.1);
  const ErrorMetrics all = Compare(reference, other, {.max_theta = kPi / 2, .phi_stride = 10});
  EXPECT_GT(all.male, 0.01);
  EXPECT_NEAR(all.mse, all.table_mse, 1e-12);
  EXPECT_GT(all.compared, below_80.compared);
  EXPECT_NEAR(all.compared / (MerlTable::kCells / 10.0), 0.75, 0.01);
}

TEST(Compare, CountsWhatTheOtherCannotTellAndLeavesItOut) {
  const ErrorMetrics whole = Compare(Constant(0.5), Constant(0.2));
  const FunctionBrdf partial([](const HalfDiff& angles) -> std::optional<Rgb> {
    if (angles.theta_h > 0.5) return std::nullopt;
    if (angles.theta_d > 0.5) return Rgb::Constant(std::nan(""));
    return Rgb::Constant(0.2);
  });
  const ErrorMetrics metrics = Compare(Constant(0.5), partial);
  EXPECT_GT(metrics.missing, 0);
  EXPECT_EQ(metrics.compared + metrics.missing, whole.compared);
  EXPECT_NEAR(metrics.mse, 0.09, 1e-12);
}

TEST(Compare, LeavesOutWhatTheReferenceCannotTell) {
  const FunctionBrdf partial([](const HalfDiff& angles) -> std::optional<Rgb> {
    if (angles.theta_h > 0.5) return std::nullopt;
    return Rgb::Constant(0.5);
  });
  const ErrorMetrics metrics = Compare(partial, Constant(0.2));
  EXPECT_EQ(metrics.missing, 0);
  EXPECT_LT(metrics.compared, Compare(Constant(0.5), Constant(0.2)).compared);
}

TEST(Compare, IsNotANumberWhenNothingCouldBeCompared) {
  const FunctionBrdf nothing([](const HalfDiff&) { return std::optional<Rgb>(); });
  const ErrorMetrics metrics = Compare(Paint(), nothing, {.phi_stride = 30});
  EXPECT_EQ(metrics.compared, 0);
  EXPECT_GT(metrics.missing, 0);
  EXPECT_TRUE(std::isnan(metrics.male));
  EXPECT_TRUE(std::isnan(metrics.mse));
}

TEST(Compare, CountsNegativePredictionsAsZeroInTheLogarithms) {
  const ErrorMetrics negative = Compare(Constant(0.5), Constant(-5));
  const ErrorMetrics zero = Compare(Constant(0.5), Constant(0));
  EXPECT_EQ(negative.male, zero.male);
  EXPECT_EQ(negative.log_relative_rms, zero.log_relative_rms);
  EXPECT_GT(negative.mse, zero.mse);
}

TEST(Compare, IsTheSameForAnyNumberOfThreads) {
  const ErrorMetrics one = Compare(Paint(), Metal(), {.phi_stride = 5});
  for (const int threads : {2, 3, 100}) {
    const ErrorMetrics many = Compare(Paint(), Metal(), {.phi_stride = 5, .threads = threads});
    EXPECT_EQ(one.male, many.male);
    EXPECT_EQ(one.log_relative_rms, many.log_relative_rms);
    EXPECT_EQ(one.mse, many.mse);
    EXPECT_EQ(one.compared, many.compared);
  }
}

TEST(Compare, IsNearlyTheSameOnEveryFourthPhi) {
  const ErrorMetrics full = Compare(Paint(), Metal());
  const ErrorMetrics fourth = Compare(Paint(), Metal(), {.phi_stride = 4});
  EXPECT_NEAR(fourth.compared / double(full.compared), 0.25, 0.01);
  EXPECT_NEAR(fourth.male, full.male, 0.01 * full.male);
}

TEST(Compare, IsNearlyTheSameOnEveryFourthThetaD) {
  const ErrorMetrics full = Compare(Paint(), Metal(), {.phi_stride = 12});
  const ErrorMetrics fourth = Compare(Paint(), Metal(), {.phi_stride = 12, .theta_d_stride = 4});
  EXPECT_NEAR(fourth.compared / double(full.compared), 0.25, 0.005);
  EXPECT_NEAR(fourth.male, full.male, 0.01 * full.male);
}

TEST(MetricOptions, PassTheirOwnCheckByDefault) { EXPECT_NO_THROW(MetricOptions{}.Check()); }

TEST(MetricOptions, AreRefusedByName) {
  const auto complaint = [](const MetricOptions& options) {
    return MessageOf<ConfigError>([&] { Compare(Paint(), Paint(), options); });
  };
  EXPECT_EQ(complaint({.max_theta = 0}), "max_theta: is 0 deg, must be > 0 and <= 90");
  EXPECT_EQ(complaint({.max_theta = kPi}), "max_theta: is 180 deg, must be > 0 and <= 90");
  EXPECT_EQ(complaint({.phi_stride = 0}), "phi_stride: is 0, must be between 1 and 180");
  EXPECT_EQ(complaint({.theta_d_stride = 91}), "theta_d_stride: is 91, must be between 1 and 90");
  EXPECT_EQ(complaint({.threads = 0}), "threads: is 0, must be >= 1");
}

TEST(Compare, SaysTheSameOfEachChannelAndOfAll) {
  const ErrorMetrics m = Compare(Paint(), Metal(), {.phi_stride = 10});
  EXPECT_NEAR(m.male, m.male_per_channel.mean(), 1e-12);
  EXPECT_NEAR(m.mse, m.mse_per_channel.mean(), 1e-12 * m.mse);
  EXPECT_NEAR(m.table_mse, m.table_mse_per_channel.mean(), 1e-12 * m.table_mse);
  EXPECT_NEAR(m.log_mse, m.log_mse_per_channel.mean(), 1e-12);
  EXPECT_NEAR(m.log_relative_rms, std::sqrt(m.log_relative_rms_per_channel.square().mean()), 1e-12);
  EXPECT_NEAR(m.cube_root_rms, std::sqrt(m.cube_root_rms_per_channel.square().mean()), 1e-12);
}

TEST(Compare, DoesNotLetAnUnknownColourSpoilTheOthers) {
  const FunctionBrdf no_blue([](const HalfDiff& x) -> std::optional<Rgb> {
    std::optional<Rgb> f_r = Metal().Eval(x);
    if (f_r) (*f_r)[2] = std::numeric_limits<double>::quiet_NaN();
    return f_r;
  });
  const ErrorMetrics all = Compare(Paint(), Metal(), {.phi_stride = 10});
  const ErrorMetrics two = Compare(Paint(), no_blue, {.phi_stride = 10});
  EXPECT_EQ(two.male_per_channel[0], all.male_per_channel[0]);
  EXPECT_EQ(two.table_mse_per_channel[1], all.table_mse_per_channel[1]);
  EXPECT_TRUE(std::isnan(two.male_per_channel[2]));
  EXPECT_NEAR(two.male, (all.male_per_channel[0] + all.male_per_channel[1]) / 2, 1e-12);
  EXPECT_EQ(two.missing, 0);
}

TEST(ErrorMap, ShowsWhereTheErrorIs) {
  const FunctionBrdf other([](const HalfDiff& x) {
    return Rgb::Constant(x.theta_h < RadFromDeg(10) && x.theta_d > RadFromDeg(30) ? 2 : 1);
  });
  const std::vector<double> map = ErrorMap(Constant(1), other, 1, {.phi_stride = 10});
  ASSERT_EQ(map.size(), 8100u);
  const auto at = [&](int h, int d) { return map[h * 90 + d]; };
  EXPECT_EQ(at(0, 20), 0);
  EXPECT_GT(at(0, 40), 0.1);
  EXPECT_EQ(at(60, 40), 0);
  EXPECT_TRUE(std::isnan(at(0, 89)));  // beyond 80 deg
}

}  // namespace
}  // namespace gonio
