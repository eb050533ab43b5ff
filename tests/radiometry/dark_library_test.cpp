// SPDX-License-Identifier: Apache-2.0
#include "acquisition/radiometry/dark_library.h"

#include <gmock/gmock.h>

#include "acquisition/radiometry/bad_pixels.h"
#include "tests/radiometry/synthetic_sensor.h"

namespace gonio {
namespace {

using testing::HasSubstr;

SyntheticSensor DarkSensor() {
  SyntheticSensor sensor;
  Random random(4, 4);
  for (std::size_t i = 0; i < sensor.format.sites(); ++i) {
    sensor.bias.push_back(static_cast<float>(2 * random.Normal()));
    sensor.dark_rate.push_back(static_cast<float>(20 * random.Uniform()));
  }
  return sensor;
}

std::vector<Frame> DarkFrames(const SyntheticSensor& sensor, std::uint64_t seed, int each = 4) {
  Random random(seed, 2);
  std::vector<Frame> frames;
  for (const double t : {0.01, 1.0, 4.0}) {
    for (int i = 0; i < each; ++i) frames.push_back(sensor.Expose({0, 0, 0}, t, 1, &random));
  }
  return frames;
}

Result<DarkLibrary> Library(const SyntheticSensor& sensor, std::uint64_t seed) {
  return MeasureDark(sensor.format, DarkFrames(sensor, seed), sensor.gain, 1000);
}

TEST(DarkLibrary, PredictsTheDarkOfAnyExposureWithinItsError) {
  const SyntheticSensor sensor = DarkSensor();
  for (const double t : {0.0, 0.5, 3.0}) {
    Scores scores;
    for (int seed = 0; seed < 20; ++seed) {
      const auto library = Library(sensor, seed);
      ASSERT_TRUE(library.ok()) << library.error().message;
      const auto dark = DarkFor(*library, sensor.format, t, 20, 2000);
      ASSERT_TRUE(dark.ok()) << dark.error().message;
      for (std::size_t i = 0; i < dark->counts.size(); ++i) {
        const double truth = sensor.bias[i] + sensor.dark_rate[i] * t / sensor.gain;
        scores.Add((dark->counts[i] - truth) / std::sqrt(dark->variance[i]));
      }
    }
    // Twenty libraries of 1024 sites: mean and deviation are known to half a per cent. The shot
    // noise of a site's current is taken from its own rate, so those that came out low claim less.
    EXPECT_NEAR(scores.mean(), 0, 0.08) << t;
    EXPECT_NEAR(scores.deviation(), 1, 0.05) << t;
  }
}

TEST(DarkLibrary, KnowsTheReadNoiseOfMostSites) {
  const SyntheticSensor sensor = DarkSensor();
  const auto library = Library(sensor, 1);
  ASSERT_TRUE(library.ok());
  const DarkFit& fit = library->fits.front();
  EXPECT_NEAR(fit.read_variance, 25.0 / 4 + 1.0 / 12, 0.5);
  EXPECT_EQ(fit.levels.size(), 3u);
  EXPECT_EQ(fit.temperature_c, 20);
}

TEST(DarkLibrary, KeepsTemperaturesApart) {
  const SyntheticSensor cold = DarkSensor();
  SyntheticSensor warm = cold;
  for (float& rate : warm.dark_rate) rate *= 4;
  std::vector<Frame> frames = DarkFrames(warm, 1);
  for (Frame& frame : frames) frame.temperature_c = 32.2;
  for (Frame& frame : DarkFrames(cold, 2)) frames.push_back(frame);
  const auto library = MeasureDark(cold.format, frames, cold.gain, 0);
  ASSERT_TRUE(library.ok()) << library.error().message;
  ASSERT_EQ(library->fits.size(), 2u);
  const auto mean = [](const SiteImage& image) {
    double sum = 0;
    for (const float v : image) sum += v;
    return sum / static_cast<double>(image.size());
  };
  const auto at = [&](double temperature) {
    return DarkFor(*library, cold.format, 4, temperature, 0);
  };
  EXPECT_NEAR(mean(at(20)->current), 20, 1);
  EXPECT_NEAR(mean(at(32)->current), 80, 2);
  EXPECT_EQ(at(20)->temperature_sigma, 0);
  EXPECT_NEAR(at(21.5)->temperature_sigma, std::exp2(0.25) - 1, 1e-9);
  EXPECT_THAT(at(26).error().message, HasSubstr("none within 2 degrees of 26"));
  EXPECT_THAT(DarkFor(*library, cold.format, 4, std::nullopt, 0).error().message,
              HasSubstr("the frame tells none"));
}

TEST(DarkLibrary, RefusesWhatItIsNotFor) {
  const SyntheticSensor sensor = DarkSensor();
  const auto library = Library(sensor, 1);
  ASSERT_TRUE(library.ok());
  const auto complaint = [&](const SensorFormat& format, double exposure, std::int64_t now) {
    const auto dark = DarkFor(*library, format, exposure, 20, now);
    return dark.ok() ? "accepted" : dark.error().message;
  };
  EXPECT_EQ(complaint(sensor.format, 4, 1000), "accepted");
  EXPECT_THAT(complaint(sensor.format, 4.1, 1000), HasSubstr("4.1 s is longer than 4 s"));
  EXPECT_THAT(complaint(sensor.format, 1, 999), HasSubstr("a clock is wrong"));
  EXPECT_THAT(complaint(sensor.format, 1, 1000 + 31 * 86400), HasSubstr("31.0 days old"));
  for (const auto& [change, word] :
       std::vector<std::pair<std::function<void(SensorFormat*)>, std::string>>{
           {[](SensorFormat* f) { f->gain_db = 6; }, "gain"},
           {[](SensorFormat* f) { f->camera = "other"; }, "camera is other"},
           {[](SensorFormat* f) { f->width = 16; }, "width"},
           {[](SensorFormat* f) { f->top = 16; }, "top"},
           {[](SensorFormat* f) { f->layout = PixelLayout::kBayerRg; }, "layout"},
           {[](SensorFormat* f) { f->full_scale = 255; }, "full scale"}}) {
    SensorFormat other = sensor.format;
    change(&other);
    EXPECT_THAT(complaint(other, 1, 1000), HasSubstr(word));
  }
}

TEST(DarkLibrary, NeedsTwoExposuresOfTwoFrames) {
  const SyntheticSensor sensor = DarkSensor();
  std::vector<Frame> frames = DarkFrames(sensor, 1, 1);
  const auto single = MeasureDark(sensor.format, frames, 2, 0);
  ASSERT_FALSE(single.ok());
  EXPECT_THAT(single.error().message, HasSubstr("one frame of 0.01 s"));
  EXPECT_FALSE(MeasureDark(sensor.format, {frames[0], frames[0]}, 2, 0).ok());
  EXPECT_FALSE(MeasureDark(sensor.format, {}, 2, 0).ok());
}

TEST(BadPixels, AreFoundAndFewOthers) {
  SyntheticSensor sensor = DarkSensor();
  sensor.dark_rate[100] = 2000;
  SiteImage response(sensor.format.sites(), 1.0F);
  response[200] = 0.1F;
  response[201] = std::nanf("");
  auto library = Library(sensor, 3);
  ASSERT_TRUE(library.ok());
  DarkFit fit = library->fits.front();
  fit.noise[300] = 60;
  const BadPixels bad = FindBadPixels(sensor.format, fit, response);
  EXPECT_TRUE(bad.mask[100] & kHotPixel);
  EXPECT_TRUE(bad.mask[300] & kNoisyPixel);
  EXPECT_TRUE(bad.mask[200] & kDeadPixel);
  EXPECT_TRUE(bad.mask[201] & kDeadPixel);
  EXPECT_EQ(bad.dead, 2u);
  EXPECT_LE(bad.fraction(), 6.0 / 1024);
  EXPECT_GE(bad.fraction(), 4.0 / 1024);
}

// A mean and a standard deviation would be moved by a tenth of bad sites until none stands out.
TEST(BadPixels, AreFoundAmongManyOthers) {
  SyntheticSensor sensor = DarkSensor();
  for (std::size_t i = 0; i < 100; ++i) sensor.dark_rate[i * 10] = 500;
  const auto library = Library(sensor, 3);
  ASSERT_TRUE(library.ok());
  const BadPixels bad = FindBadPixels(sensor.format, library->fits.front(), {});
  for (std::size_t i = 0; i < 100; ++i) EXPECT_TRUE(bad.mask[i * 10] & kHotPixel);
  EXPECT_LE(bad.hot, 101u);
}

// Red sites with more dark current than the others are no fault of theirs.
TEST(BadPixels, AreJudgedByTheirOwnColour) {
  DarkFit fit;
  SensorFormat format{.camera = "c", .width = 8, .height = 8, .layout = PixelLayout::kBayerRg};
  fit.noise.assign(64, 1);
  fit.rate.assign(64, 1);
  for (std::size_t i = 0; i < 64; ++i) fit.rate[i] += static_cast<float>(1e-2 * (i % 7));
  VisitSites(format, [&](std::size_t i, int c) { fit.rate[i] += c == 0 ? 50 : 0; });
  EXPECT_EQ(FindBadPixels(format, fit, {}).hot, 0u);
}

}  // namespace
}  // namespace gonio
