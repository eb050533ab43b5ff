// SPDX-License-Identifier: Apache-2.0
#include <gmock/gmock.h>

#include <set>

#include "acquisition/radiometry/reference_standard.h"
#include "acquisition/radiometry/stray_light.h"
#include "acquisition/radiometry/uncertainty_budget.h"
#include "core/units.h"
#include "tests/core/temp_dir.h"
#include "tests/radiometry/synthetic_sensor.h"

namespace gonio {
namespace {

using testing::HasSubstr;
using Term = UncertaintyTerm;

TEST(UncertaintyBudget, KeepsRandomAndSystematicApart) {
  UncertaintyBudget budget;
  budget[Term::kShot] = Rgb::Constant(3);
  budget[Term::kMonitor] = Rgb::Constant(4);
  budget[Term::kDark] = Rgb::Constant(5);
  budget[Term::kAngle] = Rgb::Constant(12);
  EXPECT_DOUBLE_EQ(budget.random()[0], 5);
  EXPECT_DOUBLE_EQ(budget.systematic()[1], 13);
  EXPECT_DOUBLE_EQ(budget.combined()[2], std::sqrt(194.0));
  const UncertaintyBudget mean = BudgetOfMean(budget, 25);
  EXPECT_DOUBLE_EQ(mean.random()[0], 1);
  EXPECT_DOUBLE_EQ(mean.systematic()[0], 13);
}

TEST(UncertaintyBudget, NamesEachTermOnce) {
  std::set<std::string> names;
  for (int i = 0; i < kUncertaintyTerms; ++i) names.insert(ToString(static_cast<Term>(i)));
  EXPECT_EQ(names.size(), static_cast<std::size_t>(kUncertaintyTerms));
  EXPECT_FALSE(IsSystematic(Term::kMonitor));
  EXPECT_TRUE(IsSystematic(Term::kDark));
}

// The random terms are what frames really scatter by, also where rounding is most of it.
TEST(UncertaintyBudget, PredictsTheScatterOfFrameMeans) {
  for (const double read_noise : {0.5, 5.0}) {
    SyntheticSensor sensor;
    sensor.read_noise = read_noise;
    sensor.light_noise = 0.01;
    Scores scores;
    UncertaintyBudget budget;
    const NoiseInputs inputs{.f_r = 0.3,
                             .gain_f_r = 4000,
                             .read_noise = read_noise,
                             .count = 2,
                             .sites = 1024,
                             .multiplicative = 0.01};
    SetNoise(inputs, 1, &budget);
    EXPECT_EQ(budget.combined()[0], 0);
    Random random(1, 1);
    for (int i = 0; i < 1000; ++i) {
      const Frame frame = sensor.Expose({1200, 0, 0}, 1, 1, &random);
      double sum = 0;
      for (const auto n : frame.counts) sum += n - sensor.black;
      scores.Add((sum / 1024 * 2 / 4000 - 0.3) / budget.random()[1]);
    }
    EXPECT_HONEST(scores);
  }
}

TEST(UncertaintyBudget, GivesCoarseRoundingItsFullSize) {
  UncertaintyBudget budget;
  SetNoise({.f_r = 0, .gain_f_r = 100, .count = 10, .sites = 1e6}, 0, &budget);
  EXPECT_NEAR(budget[Term::kRounding][0], 10 / std::sqrt(12.0) / 100, 1e-5);
}

TEST(UncertaintyBudget, KnowsWhatAnAngleDoes) {
  // A Lambertian sample at 60 degrees: cos is off by tan(60 deg) of the error.
  EXPECT_NEAR(AngleTerm(0.3, 0, kPi / 3, 0.001), 0.3 * std::sqrt(3.0) * 0.001, 1e-12);
  EXPECT_NEAR(AngleTerm(0.3, 40, 0, 0.001), 0.04, 1e-12);
}

constexpr const char* kStandard = R"(format: gonio-reference-standard
version: 1
name: tile
coverage_factor: 2
points:
  - {theta_i_deg: 0, theta_o_deg: 45, f_r: [0.31, 0.32, 0.33], f_r_uncertainty: [0.006, 0.006, 0.008]}
  - {theta_i_deg: 45, theta_o_deg: 0, f_r: [0.30, 0.31, 0.32], f_r_uncertainty: [0.006, 0.006, 0.008]}
)";

TEST(ReferenceStandard, IsReadAndNotExtrapolated) {
  const TempDir dir;
  const auto standard = ReferenceStandard::Load(dir.File("s.yaml", kStandard));
  EXPECT_EQ(standard.name(), "tile");
  const auto f_r = standard.At(RadFromDeg(45.2), 0, 2, RadFromDeg(0.5));
  ASSERT_TRUE(f_r.ok());
  EXPECT_DOUBLE_EQ(f_r->value, 0.32);
  EXPECT_DOUBLE_EQ(f_r->sigma, 0.004);
  EXPECT_THAT(standard.At(RadFromDeg(20), 0, 2, RadFromDeg(0.5)).error().message,
              HasSubstr("tile is not known at 20.00:0.00 degrees"));
}

TEST(ReferenceStandard, RefusesBrokenFiles) {
  const TempDir dir;
  const auto complaint = [&](const std::string& from, const std::string& to) {
    std::string text = kStandard;
    text.replace(text.find(from), from.size(), to);
    return MessageOf<ConfigError>([&] { ReferenceStandard::Load(dir.File("s.yaml", text)); });
  };
  EXPECT_THAT(complaint("version: 1", "version: 2"), HasSubstr("s.yaml:2: version"));
  EXPECT_THAT(complaint("theta_o_deg: 45", "theta_o_deg: 95"), HasSubstr("s.yaml:6"));
  EXPECT_THAT(complaint("0.31, 0.32, 0.33", "0.31, 0, 0.33"), HasSubstr("f_r"));
  EXPECT_THAT(complaint("name: tile", "nam: tile"), HasSubstr("name"));
}

TEST(Responsivity, IsFoundWithinItsError) {
  Scores single;
  Scores joined;
  Random random(1, 1);
  for (int i = 0; i < 2000; ++i) {
    const double certificate = 1 + 0.01 * random.Normal();  // one error for all poses
    std::vector<MeasuredValue> independent;
    for (int pose = 0; pose < 6; ++pose) {
      const double f_r = 0.25 + 0.02 * pose;
      const MeasuredValue rate{5e4 * f_r * (1 + 0.005 * random.Normal()), 5e4 * f_r * 0.005};
      const auto r = ResponsivityFrom(rate, {f_r * certificate, 0.01 * f_r * certificate});
      ASSERT_TRUE(r.ok());
      if (pose == 0) single.Add((r->value - 5e4) / r->sigma);
      independent.push_back(*ResponsivityFrom(rate, {f_r * certificate, 0}));
    }
    const auto all = JoinResponsivities(independent, 0.01);
    joined.Add((all.responsivity.value - 5e4) / all.responsivity.sigma);
    EXPECT_LT(all.responsivity.relative(), 0.0125);
  }
  EXPECT_HONEST(single);
  EXPECT_HONEST(joined);
  EXPECT_FALSE(ResponsivityFrom({0, 1}, {0.3, 0}).ok());
  EXPECT_FALSE(ResponsivityFrom({1, 1}, {0, 0}).ok());
}

TEST(StrayLight, IsTakenOffWithinItsError) {
  Scores scores;
  Random random(1, 1);
  for (int i = 0; i < 2000; ++i) {
    // Background 40, glare 2 %, field 5000; the trap and the black patch are measured with noise.
    const StrayLight stray{.background = {40 + 2 * random.Normal(), 2},
                           .glare = *GlareFraction({100 + 4 * random.Normal(), 4}, {5000, 0})};
    const double truth = 800;
    const MeasuredValue measured{0.98 * truth + 0.02 * 3000 + 40 + 3 * random.Normal(), 3};
    const auto found = SubtractStrayLight(measured, {3040, 0}, stray);
    ASSERT_TRUE(found.ok());
    EXPECT_LT(found->systematic, found->rate.sigma);
    scores.Add((found->rate.value - truth) / found->rate.sigma);
  }
  EXPECT_HONEST(scores);
}

TEST(StrayLight, RefusesGlareThatIsNone) {
  EXPECT_FALSE(GlareFraction({60, 1}, {100, 1}).ok());
  EXPECT_FALSE(GlareFraction({1, 1}, {0, 1}).ok());
  EXPECT_FALSE(SubtractStrayLight({1, 1}, {1, 1}, {.background = {}, .glare = {1, 0}}).ok());
}

}  // namespace
}  // namespace gonio
