// SPDX-License-Identifier: Apache-2.0
#include "acquisition/radiometry/photon_transfer.h"

#include <gmock/gmock.h>

#include "tests/radiometry/synthetic_sensor.h"

namespace gonio {
namespace {

using testing::HasSubstr;

std::vector<FlatPair> Series(const SyntheticSensor& sensor, const std::vector<double>& exposures,
                             std::uint64_t seed) {
  Random random(seed, 1);
  std::vector<FlatPair> pairs;
  for (const double t : exposures) {
    const double first = 1 + 0.05 * random.Uniform();
    const double second = 1 + 0.05 * random.Uniform();
    FlatPair pair;
    pair.first = sensor.Expose({8000, 6000, 4000}, t, first, &random);
    pair.second = sensor.Expose({8000, 6000, 4000}, t, second, &random);
    pair.monitor_first = first;
    pair.monitor_second = second;
    pairs.push_back(std::move(pair));
  }
  return pairs;
}

const std::vector<double> kExposures = {0, 0.02, 0.05, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6};

SiteImage UnevenResponse(const SensorFormat& format) {
  Random random(99, 7);
  SiteImage response(format.sites());
  for (float& r : response) r = static_cast<float>(1 + 0.2 * (random.Uniform() - 0.5));
  return response;
}

class PhotonTransfers : public testing::TestWithParam<PixelLayout> {};

// With a pattern of 6 % and a light that differs by up to 5 % within a pair: without the scaling,
// a thousandth of the signal squared would count as noise and K come out half as large.
TEST_P(PhotonTransfers, FindGainAndReadNoiseWithinTheirErrors) {
  SyntheticSensor sensor;
  sensor.format.layout = GetParam();
  sensor.response = UnevenResponse(sensor.format);
  Scores gain;
  Scores read_noise;
  Scores line;
  for (int seed = 0; seed < 400; ++seed) {
    const auto found = MeasurePhotonTransfer(sensor.format, Series(sensor, kExposures, seed));
    ASSERT_TRUE(found.ok()) << found.error().message;
    gain.Add((found->gain.value - sensor.gain) / found->gain.sigma);
    read_noise.Add((found->read_noise.value - sensor.read_noise) / found->read_noise.sigma);
    line.Add((found->chi_squared - found->degrees_of_freedom) /
             std::sqrt(2.0 * found->degrees_of_freedom));
    EXPECT_LT(found->gain.relative(), 0.03);
    EXPECT_FALSE(found->read_noise_hidden);
  }
  EXPECT_HONEST(gain);
  EXPECT_HONEST(read_noise);
  EXPECT_LT(std::abs(line.mean()), 0.3);
}

INSTANTIATE_TEST_SUITE_P(Layouts, PhotonTransfers,
                         testing::Values(PixelLayout::kMono, PixelLayout::kRgb,
                                         PixelLayout::kBayerGb),
                         [](const auto& layout) {
                           std::string name = ToString(layout.param);
                           std::erase(name, '-');
                           return name;
                         });

TEST(PhotonTransfer, LeavesBadSitesOut) {
  SyntheticSensor sensor;
  sensor.dark_rate.assign(sensor.format.sites(), 0);
  TransferOptions options;
  options.bad.assign(sensor.format.sites(), 0);
  for (std::size_t i = 0; i < 20; ++i) {
    sensor.dark_rate[i * 7] = 3000;  // as hot as the light is bright
    options.bad[i * 7] = 1;
  }
  const auto pairs = Series(sensor, kExposures, 5);
  const auto found = MeasurePhotonTransfer(sensor.format, pairs, options);
  ASSERT_TRUE(found.ok());
  EXPECT_NEAR(found->gain.value, sensor.gain, 4 * found->gain.sigma);
  EXPECT_NEAR(found->points.back().mean, 8000 * 0.6 * found->points.back().monitor / 2, 5);
}

TEST(PhotonTransfer, FindsTheFullWellWhereTheVarianceCollapses) {
  SyntheticSensor sensor;
  sensor.full_well = 5000;
  Scores scores;
  for (int seed = 0; seed < 300; ++seed) {
    const auto found = MeasurePhotonTransfer(
        sensor.format, Series(sensor, {0, 0.1, 0.2, 0.3, 0.4, 0.9, 1.2}, seed),
        {.max_fraction = 0.5, .bad = {}});
    ASSERT_TRUE(found.ok()) << found.error().message;
    EXPECT_TRUE(found->full_well_reached);
    EXPECT_FALSE(found->full_well_is_full_scale);
    scores.Add((found->full_well.value - 5000) / found->full_well.sigma);
  }
  EXPECT_HONEST(scores);
}

TEST(PhotonTransfer, SaysWhatEndsTheRange) {
  SyntheticSensor sensor;
  const auto converter =
      MeasurePhotonTransfer(sensor.format, Series(sensor, {0, 0.1, 0.3, 0.5, 2}, 1));
  ASSERT_TRUE(converter.ok());
  EXPECT_TRUE(converter->full_well_reached);
  EXPECT_TRUE(converter->full_well_is_full_scale);
  const auto open = MeasurePhotonTransfer(sensor.format, Series(sensor, {0, 0.1, 0.3}, 1));
  ASSERT_TRUE(open.ok());
  EXPECT_FALSE(open->full_well_reached);
  EXPECT_NEAR(open->full_well.value, 8000 * 0.3, 300);
}

TEST(PhotonTransfer, SaysWhenRoundingHidesTheReadNoise) {
  SyntheticSensor sensor;
  sensor.gain = 20;
  sensor.read_noise = 4;
  const auto found = MeasurePhotonTransfer(sensor.format, Series(sensor, kExposures, 1));
  ASSERT_TRUE(found.ok());
  EXPECT_TRUE(found->read_noise_hidden);
  EXPECT_NEAR(found->read_noise.value, 8, 1);
}

TEST(PhotonTransfer, RefusesWhatItCannotTell) {
  SyntheticSensor sensor;
  const auto message = [&](const SensorFormat& format, const std::vector<double>& exposures) {
    const auto found = MeasurePhotonTransfer(format, Series(sensor, exposures, 1));
    return found.ok() ? "accepted" : found.error().message;
  };
  EXPECT_THAT(message(sensor.format, {0.1, 0.2}), HasSubstr("2 points below saturation, needs 3"));
  EXPECT_THAT(message(sensor.format, {0, 0, 0}), HasSubstr("does not grow"));
  SensorFormat other = sensor.format;
  other.gain_db = 6;
  EXPECT_THAT(message(other, kExposures), HasSubstr("gain in dB is 0, calibrated for 6"));
  sensor.format.width = sensor.format.height = 8;
  EXPECT_THAT(message(sensor.format, kExposures), HasSubstr("64 good sites, needs 100"));
}

// A shutter that is always open 2 ms longer.
TEST(ExposureRatio, IsFoundWithinItsError) {
  SyntheticSensor sensor;
  sensor.light_noise = 0.01;
  Scores scores;
  const double truth = ((0.02 + 0.002) / 0.02) / ((0.4 + 0.002) / 0.4);
  for (int seed = 0; seed < 600; ++seed) {
    std::vector<FlatPair> pairs = Series(sensor, {0.022, 0.102, 0.402}, seed);
    for (FlatPair& pair : pairs) {
      pair.first.exposure -= Seconds(0.002);
      pair.second.exposure = pair.first.exposure;
    }
    const auto points = TransferPoints(sensor.format, pairs, {});
    ASSERT_TRUE(points.ok());
    const double reference = points->back().exposure;
    const auto ratios = ExposureRatios(*points, 0, reference, 0.01);
    ASSERT_TRUE(ratios.ok()) << ratios.error().message;
    scores.Add((ratios->front().ratio.value - truth) / ratios->front().ratio.sigma);
    EXPECT_EQ(ratios->back().ratio.value, 1);
    EXPECT_FALSE(ExposureRatios(*points, 0, 0.7, 0.01).ok());
  }
  EXPECT_HONEST(scores);
}

}  // namespace
}  // namespace gonio
