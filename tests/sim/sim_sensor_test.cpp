// SPDX-License-Identifier: Apache-2.0
#include "sim/sim_sensor.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

namespace gonio {
namespace {

constexpr int kSide = 200;

// An image in which every pixel gets as many electrons.
SimImage Even(double electrons, int width = kSide, int height = kSide) {
  SimImage image{.width = width, .height = height, .planes = 1, .values = {}};
  image.values.assign(image.pixels(), static_cast<float>(electrons));
  return image;
}

SimReadout Mono(double exposure = 1) {
  return {.exposure = Seconds(exposure),
          .black_level = 100,
          .layout = PixelLayout::kMono,
          .full_scale = 65535};
}

SimSensor Sensor(const SimConfig& truth, std::uint64_t seed = 1) {
  return {truth, kSide, kSide, Random(seed, 20), true};
}

struct Moments {
  double mean = 0;
  double variance = 0;
};
Moments MomentsOf(const std::vector<std::uint16_t>& counts) {
  double sum = 0;
  double squares = 0;
  for (const std::uint16_t count : counts) {
    sum += count;
    squares += static_cast<double>(count) * count;
  }
  const double mean = sum / static_cast<double>(counts.size());
  return {mean, squares / static_cast<double>(counts.size()) - mean * mean};
}

TEST(SimSensor, IsExactWithoutImperfections) {
  const Frame frame = Sensor({}).Read(Even(500), Mono());
  ASSERT_EQ(frame.counts.size(), kSide * kSide);
  for (const std::uint16_t count : frame.counts) EXPECT_EQ(count, 600);
  EXPECT_EQ(frame.black_level, 100);
  EXPECT_EQ(frame.layout, PixelLayout::kMono);
}

TEST(SimSensor, NoiseIsThatOfPhotonsAndReadout) {
  SimConfig truth;
  truth.shot_noise = true;
  truth.read_noise = 10;
  truth.electrons_per_count = 2;
  for (const double electrons : {4.0, 100.0, 20000.0}) {
    const Moments moments = MomentsOf(Sensor(truth).Read(Even(electrons), Mono()).counts);
    const double variance = (electrons + 100) / 4 + 1.0 / 12;
    EXPECT_NEAR(moments.mean, 100 + electrons / 2, 5 * std::sqrt(variance) / kSide);
    EXPECT_NEAR(moments.variance / variance, 1, 0.04) << electrons;
  }
}

TEST(SimSensor, PixelsRespondDifferentlyAndAlwaysTheSame) {
  SimConfig truth;
  truth.prnu = 0.02;
  const Frame frame = Sensor(truth).Read(Even(10000), Mono());
  const Moments moments = MomentsOf(frame.counts);
  EXPECT_NEAR(moments.mean, 10100, 5);
  EXPECT_NEAR(std::sqrt(moments.variance), 200, 4);
  EXPECT_EQ(Sensor(truth, 2).Read(Even(10000), Mono()).counts, frame.counts);
  truth.sensor_seed = 2;
  EXPECT_NE(Sensor(truth).Read(Even(10000), Mono()).counts, frame.counts);
}

TEST(SimSensor, ARegionHasTheSamePixels) {
  SimConfig truth;
  truth.prnu = 0.02;
  truth.dsnu = 5;
  SimSensor sensor = Sensor(truth);
  const Frame whole = sensor.Read(Even(10000), Mono());
  SimReadout readout = Mono();
  readout.region = {.x = 50, .y = 60, .width = 30, .height = 20};
  const Frame part = sensor.Read(Even(10000, 30, 20), readout);
  ASSERT_EQ(part.counts.size(), 600);
  for (int y = 0; y < 20; ++y) {
    for (int x = 0; x < 30; ++x) {
      EXPECT_EQ(part.counts[y * 30 + x], whole.counts[(60 + y) * kSide + 50 + x]);
    }
  }
  // Another sensor of the same seed that is larger agrees, too.
  SimSensor larger(truth, 2 * kSide, kSide, Random(1, 1), true);
  readout.region = {.x = 0, .y = 0, .width = kSide, .height = kSide};
  EXPECT_EQ(larger.Read(Even(10000), readout).counts, whole.counts);
}

TEST(SimSensor, OffsetsDoNotDependOnTheExposure) {
  SimConfig truth;
  truth.dsnu = 8;
  for (const double exposure : {0.01, 10.0}) {
    EXPECT_NEAR(std::sqrt(MomentsOf(Sensor(truth).Read(Even(0), Mono(exposure)).counts).variance),
                8, 0.2);
  }
}

TEST(SimSensor, HotPixelsAreAsManyAsPlantedAndGrowWithTime) {
  SimConfig truth;
  truth.hot_pixels = 0.01;
  truth.hot_dark_current = 1000;
  truth.dark_current = 50;
  SimSensor sensor = Sensor(truth);
  const Frame frame = sensor.Read(Even(0), Mono(2));
  const auto hot = std::count(frame.counts.begin(), frame.counts.end(), 100 + 2100);
  const auto cold = std::count(frame.counts.begin(), frame.counts.end(), 100 + 100);
  EXPECT_NEAR(static_cast<double>(hot), 400, 80);
  EXPECT_EQ(hot + cold, kSide * kSide);
}

TEST(SimSensor, DarkCurrentsSpread) {
  SimConfig truth;
  truth.dark_current = 1000;
  truth.dark_spread = 0.1;
  const Moments moments = MomentsOf(Sensor(truth).Read(Even(0), Mono(2)).counts);
  EXPECT_NEAR(moments.mean, 2100, 4);
  EXPECT_NEAR(std::sqrt(moments.variance), 200, 5);
}

TEST(SimSensor, DarkCurrentDoublesWithTemperature) {
  SimConfig truth;
  truth.dark_current = 100;
  truth.dark_doubling = 7;
  truth.reference_c = 25;
  SimSensor sensor = Sensor(truth);
  SimReadout readout = Mono(2);
  const auto dark = [&](std::optional<double> temperature) {
    readout.temperature_c = temperature;
    return sensor.Read(Even(0), readout).counts[0] - 100;
  };
  EXPECT_EQ(dark(25), 200);
  EXPECT_EQ(dark(32), 400);
  EXPECT_EQ(dark(11), 50);
  EXPECT_EQ(dark(std::nullopt), 200);
}

TEST(SimSensor, GainLeavesFewerElectronsToACount) {
  SimConfig truth;
  truth.electrons_per_count = 4;
  SimReadout readout = Mono();
  readout.gain_db = 20 * std::log10(2.0);
  const Frame frame = Sensor(truth).Read(Even(1000), readout);
  EXPECT_EQ(frame.counts[0], 600);
  EXPECT_EQ(frame.gain_db, readout.gain_db);
}

// At full scale (1000 counts above black) 4 % are missing, at half of it 2 %.
TEST(SimSensor, CountsBendAsPlanted) {
  SimConfig truth;
  truth.electrons_per_count = 10;
  SimReadout readout = Mono();
  readout.full_scale = 1100;
  for (const double bend : {0.04, -0.04}) {
    truth.nonlinearity = bend;
    SimSensor sensor = Sensor(truth);
    const auto counts = [&](double electrons) {
      return sensor.Read(Even(electrons), readout).counts[0];
    };
    EXPECT_EQ(counts(9999.9), std::min(1100.0, 100 + 1000 * (1 - bend)));
    EXPECT_EQ(counts(5000), 100 + 500 * (1 - bend / 2));
    EXPECT_EQ(counts(20000), 1100);
    EXPECT_EQ(counts(1e6), 1100);
  }
}

TEST(SimSensor, SaturatesWhereAPixelIsFullAndWhereCountsEnd) {
  SimConfig truth;
  truth.full_well = 3000;
  SimReadout readout = Mono();
  EXPECT_EQ(Sensor(truth).Read(Even(5000), readout).counts[0], 3100);
  readout.full_scale = 1023;
  EXPECT_EQ(Sensor(truth).Read(Even(5000), readout).counts[0], 1023);
}

TEST(SimSensor, EachPixelOfAMosaicSeesItsColour) {
  SimImage image{.width = 4, .height = 2, .planes = 3, .values = {}};
  for (const float electrons : {100.F, 200.F, 300.F}) {
    image.values.insert(image.values.end(), image.pixels(), electrons);
  }
  SimSensor sensor({}, 4, 2, Random(1, 1), true);
  SimReadout readout = Mono();
  readout.black_level = 0;
  const auto counts = [&](PixelLayout layout) {
    readout.layout = layout;
    return sensor.Read(image, readout).counts;
  };
  using Counts = std::vector<std::uint16_t>;
  EXPECT_EQ(counts(PixelLayout::kBayerRg), (Counts{100, 200, 100, 200, 200, 300, 200, 300}));
  EXPECT_EQ(counts(PixelLayout::kBayerGb), (Counts{200, 300, 200, 300, 100, 200, 100, 200}));
  const Counts rgb = counts(PixelLayout::kRgb);
  EXPECT_EQ(Counts(rgb.begin(), rgb.begin() + 4), (Counts{100, 200, 300, 100}));
  EXPECT_EQ(rgb.size(), 24);
}

TEST(SimSensor, SameSeedSameNoise) {
  SimConfig truth;
  truth.shot_noise = true;
  truth.multiplicative_noise = 0.01;
  const auto counts = [&](std::uint64_t seed) {
    return Sensor(truth, seed).Read(Even(1000), Mono()).counts;
  };
  EXPECT_EQ(counts(1), counts(1));
  EXPECT_NE(counts(1), counts(2));
}

}  // namespace
}  // namespace gonio
