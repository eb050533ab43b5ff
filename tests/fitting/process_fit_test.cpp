// SPDX-License-Identifier: Apache-2.0
// A process from learning to prediction.
#include "fitting/process_fit.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "core/error.h"
#include "fitting/generalised_log.h"
#include "tests/core/temp_dir.h"
#include "tests/fitting/small_process.h"
#include "tests/fitting/synthetic.h"

namespace gonio {
namespace {

// Between the paints that were learned from, and like none of them.
AnalyticBrdf Unseen() { return PaintOf(0.22, 0.2); }

std::vector<BrdfSample> Readings(const Brdf& material, int count, double noise,
                                 std::uint64_t seed = 1) {
  Random random(seed, 0);
  std::vector<BrdfSample> samples;
  for (int n = 0; n < count; ++n) {
    samples.push_back(ReadingAt(material, RandomPose(random), noise, random));
  }
  return samples;
}

// Mean |log ratio| over random directions.
double ErrorOf(const Brdf& truth, const Brdf& fit) {
  Random random(99, 0);
  double sum = 0;
  for (int n = 0; n < 300; ++n) {
    const DirectionPair pair = RandomPose(random);
    const Rgb ratio = (*truth.Eval(pair) + 0.01) / (*fit.Eval(pair) + 0.01);
    sum += ratio.log().abs().mean() / 300;
  }
  return sum;
}

TEST(GeneralisedLog, IsTurnedRound) {
  for (const double f : {-0.3, 0.0, 1e-4, 0.2, 40.0}) {
    EXPECT_NEAR(FromGeneralisedLog(GeneralisedLog(f, 0.01), 0.01), f, 1e-12 * (1 + std::abs(f)));
  }
}

TEST(ProcessFit, LearnsAMaterialItHasNotSeenFromAFewReadings) {
  const AnalyticBrdf material = Unseen();
  const double few =
      ErrorOf(material, *FitProcess(Readings(material, 4, 0.01), SmallProcessPrior()));
  const double some =
      ErrorOf(material, *FitProcess(Readings(material, 16, 0.01), SmallProcessPrior()));
  EXPECT_LT(some, 0.06);
  EXPECT_LT(some, few);
}

TEST(ProcessFit, HoldsTheTruthInItsIntervals) {
  int inside = 0;
  int all = 0;
  for (const double albedo : {0.15, 0.25, 0.45}) {
    const AnalyticBrdf material = PaintOf(0.25, albedo);
    const auto fit = FitProcess(Readings(material, 20, 0.01), SmallProcessPrior());
    Random random(5, 0);
    for (int n = 0; n < 200; ++n, all += kChannels) {
      const DirectionPair pair = RandomPose(random);
      const Interval interval = fit->PredictInterval(ToHalfDiff(pair), 0.9);
      const Rgb f = *material.Eval(pair);
      inside += static_cast<int>((f >= interval.low && f <= interval.high).count());
    }
  }
  EXPECT_GT(inside, 0.8 * all);
}

TEST(ProcessFit, GrowsSurerAndItsIntervalsNest) {
  const AnalyticBrdf material = Unseen();
  const auto few = FitProcess(Readings(material, 5, 0.01), SmallProcessPrior());
  const auto many = FitProcess(Readings(material, 60, 0.01), SmallProcessPrior());
  const HalfDiff angles{0.3, 0.5, 1};
  EXPECT_LT(many->SpreadAt(angles).maxCoeff(), few->SpreadAt(angles).maxCoeff());
  const Interval half = few->PredictInterval(angles, 0.5);
  const Interval most = few->PredictInterval(angles, 0.95);
  EXPECT_TRUE((most.low < half.low && half.high < most.high).all());
  const Rgb f = *few->Eval(angles);
  EXPECT_TRUE((half.low < f && f < half.high).all());
  const Prediction prediction = few->Predict(angles);
  EXPECT_TRUE((prediction.f_r == f).all());
  EXPECT_TRUE((prediction.sigma > 0).all());
}

double NormalBelow(double x) { return 0.5 * std::erfc(-x / std::sqrt(2.0)); }

TEST(NarrowestBounds, HoldWhatTheyShouldOfAGaussianThatIsNotBelowTheLeast) {
  constexpr double kLeast = -1.5;
  for (const double mean : {3.0, -1.0, -1.5, -3.0, -20.0}) {
    for (const double probability : {0.5, 0.9, 0.99}) {
      const double sd = 0.8;
      const auto above = [&](double x) { return NormalBelow((mean - x) / sd); };
      const Bounds bounds = NarrowestBounds(mean, sd, kLeast, probability);
      EXPECT_GE(bounds.low, kLeast);
      const double held = (above(bounds.low) - above(bounds.high)) / above(kLeast);
      EXPECT_NEAR(held, probability, 1e-6) << mean;
      // Narrowest: about the mean, or as near to it as the least allows.
      const double up = (bounds.low + bounds.high) / 2 - mean;
      EXPECT_NEAR(up, bounds.low > kLeast ? 0 : std::max(up, 0.0), 1e-9) << mean;
    }
  }
}

TEST(NarrowestBounds, FarBelowTheLeastStillEndSomewhere) {
  const Bounds bounds = NarrowestBounds(-50, 1, 0, 0.9);  // no tail that a double could tell from 0
  EXPECT_EQ(bounds.low, 0);
  EXPECT_NEAR(bounds.high, std::log(10) / 50, 1e-3);
  const Bounds point = NarrowestBounds(-50, 0, 0, 0.9);
  EXPECT_EQ(point.low, 0);
  EXPECT_EQ(point.high, 0);
}

// Where a process expects less than nothing, what can be is not nothing for certain.
TEST(ProcessFit, GivesTheDarkAnIntervalThatBeginsAtZero) {
  const AnalyticBrdf material = PaintOf(0.2, 0.01);
  std::vector<BrdfSample> samples = Readings(material, 20, 0.01);
  for (BrdfSample& sample : samples) {  // a detector that reads too little
    sample.f_r -= 0.03;
    sample.sigma = Rgb::Constant(0.003);
  }
  const auto fit = FitProcess(samples, SmallProcessPrior());
  const HalfDiff angles{0.8, 0.3, 1};
  EXPECT_TRUE((*fit->Eval(angles) == 0).all());
  const Interval interval = fit->PredictInterval(angles, 0.9);
  EXPECT_TRUE((interval.low == 0).all());
  EXPECT_TRUE((interval.high > 0 && interval.high < 0.03).all());
}

TEST(ProcessFit, IsNotThrownByOneWildReading) {
  const AnalyticBrdf material = Unseen();
  std::vector<BrdfSample> samples = Readings(material, 30, 0.01);
  const double before = ErrorOf(material, *FitProcess(samples, SmallProcessPrior()));
  samples[7].f_r *= 3;
  samples[7].sigma *= 3;
  EXPECT_LT(ErrorOf(material, *FitProcess(samples, SmallProcessPrior())), 2 * before + 0.01);
}

TEST(ProcessFit, DoesWithoutAChannelThatIsMissing) {
  const AnalyticBrdf material = Unseen();
  std::vector<BrdfSample> samples = Readings(material, 30, 0.01);
  for (std::size_t n = 0; n < samples.size(); n += 3) {
    samples[n].f_r[2] = 0;
    samples[n].sigma[2] = std::numeric_limits<double>::infinity();
  }
  EXPECT_LT(ErrorOf(material, *FitProcess(samples, SmallProcessPrior())), 0.08);
}

TEST(ProcessFit, KnowsNothingBelowTheHorizon) {
  const auto fit = FitProcess(Readings(Unseen(), 5, 0.01), SmallProcessPrior());
  EXPECT_FALSE(fit->Eval(HalfDiff{1.4, 1.4, 0.1}).has_value());
}

TEST(ProcessFit, RefusesWhatItCannotFit) {
  const std::vector<BrdfSample> samples = Readings(Unseen(), 3, 0.01);
  EXPECT_EQ(MessageOf<ConfigError>([&] { FitProcess(samples, GenericPrior()); }),
            "prior generic: has no process; learn one with gonio prior learn");
  EXPECT_EQ(MessageOf<ConfigError>([&] { FitProcess({}, SmallProcessPrior()); }),
            "nothing to fit: no sample has a channel with a finite sigma");
}

TEST(LearnPrior, NamesItsMaterialsAndIsTheSameForAnyNumberOfThreads) {
  const AnalyticBrdf a = PaintOf(0.2, 0.1);
  const AnalyticBrdf b = PaintOf(0.3, 0.4);
  const AnalyticBrdf c = PaintOf(0.4, 0.2);
  const std::vector<TrainingMaterial> materials = {{"a", &a}, {"b", &b}, {"c", &c}};
  LearnOptions options = SmallLearnOptions();
  const Prior one = LearnPrior(materials, options);
  options.threads = 2;
  const Prior two = LearnPrior(materials, options);
  EXPECT_EQ(one.materials, (std::vector<std::string>{"a", "b", "c"}));
  EXPECT_EQ(one.process->luminance, two.process->luminance);
  EXPECT_EQ(one.process->stationary_chroma, two.process->stationary_chroma);
}

TEST(LearnPrior, RefusesTooFewAndTheSameTwice) {
  const AnalyticBrdf a = PaintOf(0.2, 0.1);
  const std::vector<TrainingMaterial> few = {{"a", &a}, {"b", &a}};
  EXPECT_EQ(MessageOf<ConfigError>([&] { LearnPrior(few, SmallLearnOptions()); }),
            "a prior is learned from 3 materials or more, not from 2");
  const std::vector<TrainingMaterial> twice = {{"a", &a}, {"b", &a}, {"a", &a}};
  EXPECT_EQ(MessageOf<ConfigError>([&] { LearnPrior(twice, SmallLearnOptions()); }),
            "a: is named twice among the materials");
}

TEST(LearnPrior, LearnsFromGreyMaterialsToo) {
  std::vector<AnalyticBrdf> greys;
  for (const double albedo : {0.1, 0.2, 0.4}) {
    greys.emplace_back("grey", std::vector<Layer>{Lambert{{albedo, albedo, albedo}}});
  }
  const std::vector<TrainingMaterial> materials = {
      {"a", &greys[0]}, {"b", &greys[1]}, {"c", &greys[2]}};
  const TempDir dir;
  WritePrior(dir / "prior.yaml", LearnPrior(materials, SmallLearnOptions()));
  const Prior read = ReadPrior(dir / "prior.yaml");
  const AnalyticBrdf unseen("unseen", std::vector<Layer>{Lambert{{0.3, 0.3, 0.3}}});
  const HalfDiff angles{0.3, 0.5, 1};
  const Rgb found = *FitProcess(Readings(unseen, 12, 0.01), read)->Eval(angles);
  EXPECT_LT((found / *unseen.Eval(angles) - 1).abs().maxCoeff(), 0.05);
}

TEST(PriorFile, KeepsAProcessToFourDigits) {
  const TempDir dir;
  WritePrior(dir / "prior.yaml", SmallProcessPrior());
  const Prior read = ReadPrior(dir / "prior.yaml");
  ASSERT_NE(read.process, nullptr);
  EXPECT_EQ(read.process->basis, SmallProcessPrior().process->basis);
  EXPECT_EQ(read.process->floor, SmallProcessPrior().process->floor);
  EXPECT_EQ(read.process->error_margin, SmallProcessPrior().process->error_margin);
  EXPECT_TRUE(read.process->luminance.isApprox(SmallProcessPrior().process->luminance, 1e-3));
  EXPECT_TRUE(read.process->chroma.isApprox(SmallProcessPrior().process->chroma, 1e-3));
  EXPECT_TRUE(read.process->mean.isApprox(SmallProcessPrior().process->mean, 1e-3));
  const std::vector<BrdfSample> samples = Readings(Unseen(), 12, 0.01);
  const HalfDiff angles{0.3, 0.5, 1};
  const Rgb before = *FitProcess(samples, SmallProcessPrior())->Eval(angles);
  EXPECT_LT((*FitProcess(samples, read)->Eval(angles) / before - 1).abs().maxCoeff(), 1e-3);
}

TEST(Calibration, InterpolatesBetweenItsProbabilities) {
  const std::vector<Calibration> calibration = {{0.5, 1}, {0.9, 2}};
  EXPECT_EQ(WideningAt({}, 0.7), 1);
  EXPECT_EQ(WideningAt(calibration, 0.2), 1);
  EXPECT_NEAR(WideningAt(calibration, 0.7), 1.5, 1e-12);
  EXPECT_EQ(WideningAt(calibration, 0.99), 2);
}

}  // namespace
}  // namespace gonio
