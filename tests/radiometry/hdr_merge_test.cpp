// SPDX-License-Identifier: Apache-2.0
#include "acquisition/radiometry/hdr_merge.h"

#include <gmock/gmock.h>

#include <numeric>

#include "acquisition/radiometry/flat_field.h"
#include "acquisition/radiometry/region_statistics.h"
#include "tests/radiometry/synthetic_sensor.h"

namespace gonio {
namespace {

SensorModel ModelOf(const SyntheticSensor& sensor) {
  SensorModel model;
  model.format = sensor.format;
  model.gain = sensor.gain;
  model.read_noise = sensor.read_noise;
  return model;
}

std::vector<CorrectedFrame> Frames(const SyntheticSensor& sensor, double rate,
                                   const std::vector<double>& exposures, Random* random,
                                   const SensorModel& model) {
  std::vector<CorrectedFrame> frames;
  for (const double t : exposures) {
    auto frame =
        Correct(model, sensor.Expose({rate, 0.7 * rate, 0.4 * rate}, t, 0.9, random), 0.9, nullptr);
    EXPECT_TRUE(frame.ok());
    frames.push_back(std::move(frame).value());
  }
  return frames;
}

std::vector<std::uint32_t> AllPixels(const SensorFormat& format) {
  std::vector<std::uint32_t> pixels(static_cast<std::size_t>(format.width) * format.height);
  std::iota(pixels.begin(), pixels.end(), 0u);
  return pixels;
}

struct Case {
  const char* name;
  PixelLayout layout;
  double low;   // electrons/s of the brightest channel
  double high;  // drawn between the two, evenly in logarithm
};

class Merges : public testing::TestWithParam<Case> {};

// Full scale is 8062 electrons; exposures 0.01 .. 0.64 s at light 0.9. NearFullScale sweeps the
// longest exposure through it: a frame that is used only when noise takes it down would pull the
// mean 0.3 sigma low there.
TEST_P(Merges, GiveHonestRegionMeans) {
  SyntheticSensor sensor;
  sensor.format.width = sensor.format.height = 16;
  sensor.format.layout = GetParam().layout;
  sensor.light_noise = 0.012;
  const SensorModel model = ModelOf(sensor);
  const double n =
      GetParam().layout == PixelLayout::kMono || GetParam().layout == PixelLayout::kRgb ? 256 : 64;
  std::array<Scores, kChannels> scores;
  for (int seed = 0; seed < 1500; ++seed) {
    Random random(seed, 5);
    const double rate =
        GetParam().low * std::pow(GetParam().high / GetParam().low, random.Uniform());
    const auto frames = Frames(sensor, rate, {0.01, 0.04, 0.16, 0.64}, &random, model);
    const auto merged = Merge(frames, {.shared_noise = 0.012, .averaged_sites = n});
    ASSERT_TRUE(merged.ok());
    const auto found = StatisticsOf(*merged, AllPixels(sensor.format), {});
    for (std::size_t c = 0; c < kChannels; ++c) {
      const double truth =
          rate *
          (n == 256 && GetParam().layout == PixelLayout::kMono ? 1 : std::array{1.0, 0.7, 0.4}[c]);
      scores[c].Add((found[c].mean - truth) / found[c].sigma());
    }
  }
  for (const Scores& s : scores) {
    EXPECT_HONEST(s);
  }
}

INSTANTIATE_TEST_SUITE_P(Scenes, Merges,
                         testing::Values(Case{"Bright", PixelLayout::kMono, 1e4, 1e5},
                                         Case{"NearFullScale", PixelLayout::kMono, 1.25e4, 1.55e4},
                                         Case{"Dim", PixelLayout::kMono, 5, 50},
                                         Case{"Rgb", PixelLayout::kRgb, 1e3, 1e5},
                                         Case{"Bayer", PixelLayout::kBayerGr, 1e3, 1e5}),
                         [](const auto& scene) { return scene.param.name; });

// The law in the header: sites first or frames first makes no difference.
TEST(Merge, OfSitesEqualsThatOfFrameMeans) {
  SyntheticSensor sensor;
  sensor.format.width = sensor.format.height = 16;
  sensor.light_noise = 0.02;
  Random random(3, 3);
  const std::vector<double> exposures = {0.05, 0.2, 0.4};
  const auto frames = Frames(sensor, 5000, exposures, &random, ModelOf(sensor));
  const auto merged = Merge(frames, {.shared_noise = 0.02, .averaged_sites = 256});
  ASSERT_TRUE(merged.ok());
  const auto found = StatisticsOf(*merged, AllPixels(sensor.format), {}, 0);
  // Straight from the formulas, with frame means.
  std::vector<double> means, gains;
  for (const CorrectedFrame& frame : frames) {
    means.push_back(std::accumulate(frame.electrons.begin(), frame.electrons.end(), 0.0) / 256);
    gains.push_back(frame.gain());
  }
  const double x = std::accumulate(means.begin(), means.end(), 0.0) /
                   std::accumulate(gains.begin(), gains.end(), 0.0);
  double weights = 0, weighted = 0;
  for (std::size_t k = 0; k < means.size(); ++k) {
    const double variance =
        (x * gains[k] + frames[k].floor) / 256 + std::pow(0.02 * x * gains[k], 2);
    weights += gains[k] * gains[k] / variance;
    weighted += gains[k] * means[k] / variance;
  }
  EXPECT_NEAR(found[0].mean / (weighted / weights), 1, 1e-6);
  // It takes the shot noise from the merged rate instead of x, which differ by the light's noise.
  EXPECT_NEAR(found[0].sigma() * std::sqrt(weights), 1, 0.02);
}

// What the taper is for: without it, sites of the long exposure that noise kept below full scale
// are used and the others not.
TEST(Merge, WithoutTheTaperIsLowNearFullScale) {
  SyntheticSensor sensor;
  sensor.format.width = sensor.format.height = 16;
  Scores hard;
  Scores tapered;
  for (int seed = 0; seed < 300; ++seed) {
    Random random(seed, 6);
    const double rate = 7890 / (0.9 * 0.64);  // two sigma of a site below full scale
    const auto frames = Frames(sensor, rate, {0.16, 0.64}, &random, ModelOf(sensor));
    for (const bool taper : {false, true}) {
      MergeOptions options{.averaged_sites = 256};
      if (!taper) options.taper_begin = 2, options.taper_end = 3;
      const auto merged = Merge(frames, options);
      ASSERT_TRUE(merged.ok());
      const auto found = StatisticsOf(*merged, AllPixels(sensor.format), {}, 0);
      (taper ? tapered : hard).Add((found[0].mean - rate) / found[0].sigma());
    }
  }
  EXPECT_LT(hard.mean(), -0.5);
  EXPECT_NEAR(tapered.mean(), 0, tapered.mean_limit());
}

TEST(Merge, MasksSaturatedSitesAndTheirNeighbours) {
  SyntheticSensor sensor;
  sensor.response.assign(sensor.format.sites(), 1.0F);
  const std::size_t bright = 10 * 32 + 10;
  sensor.response[bright] = 100;
  Random random(1, 1);
  const auto frames = Frames(sensor, 3000, {0.001, 0.4}, &random, ModelOf(sensor));
  EXPECT_EQ(frames[1].unusable[bright], kSaturatedSite);
  EXPECT_EQ(frames[1].unusable[bright + 33], kSaturatedSite);
  EXPECT_EQ(frames[1].unusable[bright + 2], 0);
  const auto merged = Merge(frames);
  ASSERT_TRUE(merged.ok());
  EXPECT_EQ(merged->state[bright], 0);
  EXPECT_NEAR(merged->rate[bright], 3e5, 5 * std::sqrt(merged->variance[bright]));
  EXPECT_EQ(merged->state[bright + 1], kAllDark);  // its light is known from the short frame only
  EXPECT_EQ(merged->state[bright + 2], 0);
  EXPECT_GT(merged->variance[bright + 1], 100 * merged->variance[bright + 2]);
  const auto clipped = Merge({frames[1]});
  ASSERT_TRUE(clipped.ok());
  EXPECT_EQ(clipped->state[bright], kAllSaturated);
  EXPECT_TRUE(std::isinf(clipped->variance[bright]));
  EXPECT_EQ(clipped->rate[bright], 0);
}

TEST(Merge, TellsBadDarkAndSaturatedApart) {
  SyntheticSensor sensor;
  SensorModel model = ModelOf(sensor);
  model.bad.assign(sensor.format.sites(), 0);
  model.bad[5] = 1;
  Random random(1, 1);
  const auto dark = Merge(Frames(sensor, 0, {0.1, 0.2}, &random, model));
  const auto light = Merge(Frames(sensor, 1e7, {0.1, 0.2}, &random, model));
  ASSERT_TRUE(dark.ok() && light.ok());
  EXPECT_EQ(dark->state[5], kAllBad);
  EXPECT_EQ(dark->state[6], kAllDark);
  EXPECT_TRUE(std::isfinite(dark->variance[6]));
  EXPECT_EQ(light->state[5], kAllBad);
  EXPECT_EQ(light->state[6], kAllSaturated);
  const auto found = StatisticsOf(*light, AllPixels(sensor.format), {});
  EXPECT_EQ(found[0].used, 0);
  EXPECT_EQ(found[0].saturated, 1023);
  EXPECT_EQ(found[0].bad, 1);
  EXPECT_TRUE(std::isinf(found[0].sigma()));
}

TEST(Merge, SubtractsTheDarkOfEachExposure) {
  SyntheticSensor sensor;
  sensor.read_noise = 3;
  Random random(8, 8);
  for (std::size_t i = 0; i < sensor.format.sites(); ++i) {
    sensor.dark_rate.push_back(static_cast<float>(500 * random.Uniform()));
  }
  std::vector<Frame> darks;
  for (const double t : {0.01, 2.0}) {
    for (int i = 0; i < 50; ++i) darks.push_back(sensor.Expose({0, 0, 0}, t, 1, &random));
  }
  const auto library = MeasureDark(sensor.format, darks, sensor.gain, 0);
  ASSERT_TRUE(library.ok());
  Scores scores;
  for (int round = 0; round < 10; ++round) {
    std::vector<CorrectedFrame> frames;
    for (const double t : {0.1, 1.0}) {
      const auto dark = DarkFor(*library, sensor.format, t, 20, 0);
      ASSERT_TRUE(dark.ok());
      auto frame = Correct(ModelOf(sensor), sensor.Expose({200, 0, 0}, t, 1, &random), 1, &*dark);
      ASSERT_TRUE(frame.ok());
      frames.push_back(std::move(frame).value());
    }
    const auto merged = Merge(frames);
    ASSERT_TRUE(merged.ok());
    for (std::size_t i = 0; i < merged->rate.size(); ++i) {
      scores.Add((merged->rate[i] - 200) / std::sqrt(merged->variance[i]));
    }
  }
  EXPECT_NEAR(scores.mean(), 0, 0.1);  // sites take their variance from their own signal
  EXPECT_NEAR(scores.deviation(), 1, 0.06);
}

TEST(Merge, RefusesWhatDoesNotBelongTogether) {
  SyntheticSensor sensor;
  Random random(1, 1);
  auto frames = Frames(sensor, 1000, {0.1, 0.2}, &random, ModelOf(sensor));
  frames[1].format.gain_db = 3;
  EXPECT_FALSE(Merge(frames).ok());
  frames.pop_back();
  frames[0].monitor = 0;
  EXPECT_FALSE(Merge(frames).ok());
  EXPECT_FALSE(Merge({}).ok());
}

TEST(FlatField, IsFoundWithinItsErrorAndTakenOut) {
  SyntheticSensor sensor;
  sensor.format.layout = PixelLayout::kBayerRg;
  Random random(2, 2);
  for (std::size_t i = 0; i < sensor.format.sites(); ++i) {
    sensor.response.push_back(static_cast<float>(1 + 0.1 * random.Normal()));
  }
  Scores scores;
  SensorModel model = ModelOf(sensor);
  model.bad.assign(sensor.format.sites(), 0);
  model.bad[77] = 1;
  for (int round = 0; round < 5; ++round) {
    const auto flat = MeasureFlatField(Frames(sensor, 5000, {0.5, 0.5, 0.5, 0.5}, &random, model));
    ASSERT_TRUE(flat.ok()) << flat.error().message;
    for (int c = 0; c < kChannels; ++c) {
      const auto found = ChannelValues(sensor.format, flat->response, c, model.bad);
      const auto truth = ChannelValues(sensor.format, sensor.response, c, model.bad);
      const auto sigma = ChannelValues(sensor.format, flat->sigma, c, model.bad);
      double sum_found = 0, sum_truth = 0;
      for (std::size_t i = 0; i < found.size(); ++i) sum_found += found[i], sum_truth += truth[i];
      EXPECT_NEAR(sum_found / found.size(), 1, 1e-5);
      for (std::size_t i = 0; i < found.size(); ++i) {
        scores.Add((found[i] - truth[i] * found.size() / sum_truth) / sigma[i]);
      }
    }
    EXPECT_TRUE(std::isinf(flat->sigma[77]));
    auto merged = Merge(Frames(sensor, 5000, {0.5}, &random, model));
    ASSERT_TRUE(merged.ok());
    const auto pixels = AllPixels(sensor.format);
    EXPECT_GT(StatisticsOf(*merged, pixels, {})[0].unevenness, 0.08);
    ASSERT_TRUE(ApplyFlatField(*flat, &*merged).ok());
    EXPECT_LT(StatisticsOf(*merged, pixels, {})[0].unevenness, 0.02);
    EXPECT_EQ(merged->state[77], kAllBad);
    EXPECT_NEAR(FlatTerm(*flat, {0, 2, 4, 6}), flat->sigma[0] / flat->response[0] / 2, 0.003);
  }
  EXPECT_NEAR(scores.mean(), 0, 0.06);
  EXPECT_NEAR(scores.deviation(), 1, 0.05);
}

TEST(RegionStatistics, LeaveOutliersOutAndSeeLight) {
  MergedImage image;
  image.format = {.camera = "c", .width = 10, .height = 10};
  Random random(1, 9);
  std::vector<float> lights;
  for (int i = 0; i < 100; ++i) {
    lights.push_back(0.5F + 0.01F * static_cast<float>(i));
    image.rate.push_back(static_cast<float>(100 * lights.back() + random.Normal()));
    image.variance.push_back(1);
    image.shared.push_back(1e-4F);
    image.state.push_back(0);
  }
  image.rate[40] = 5000;
  const auto found = StatisticsOf(image, AllPixels(image.format), lights);
  EXPECT_EQ(found[2].used, 99);
  EXPECT_EQ(found[2].outliers, 1);
  EXPECT_NEAR(found[2].mean, 100, 4 * std::sqrt(found[2].variance));
  EXPECT_NEAR(found[2].variance, 1 / (99 * found[2].light * found[2].light), 1e-6);
  EXPECT_NEAR(found[2].shared, 1e-4, 1e-9);
  EXPECT_LT(found[2].unevenness, 0.01);
  EXPECT_EQ(StatisticsOf(image, AllPixels(image.format), lights, 0)[0].outliers, 0);
}

}  // namespace
}  // namespace gonio
