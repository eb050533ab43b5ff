// SPDX-License-Identifier: Apache-2.0
#include "acquisition/exposure.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>

#include "tests/acquisition/simulated_rig.h"

namespace gonio {
namespace {

constexpr double kBlack = 64;

// A noiseless frame of a scene that gives `rates` counts per second.
Exposure Take(const Rgb& rates, Seconds exposure, const RigConfig& rig) {
  Exposure taken;
  taken.frame = {.width = rig.camera.width,
                 .height = rig.camera.height,
                 .counts = {},
                 .exposure = exposure,
                 .black_level = kBlack};
  const std::size_t size = rig.camera.width * rig.camera.height * kChannels;
  for (std::size_t i = 0; i < size; ++i) {
    const int c = i % kChannels;
    const double count = std::round(kBlack + rates[c] * exposure.count());
    taken.frame.counts.push_back(std::min<double>(count, rig.camera.full_scale));
    taken.saturated[c] = count >= rig.camera.full_scale;
  }
  return taken;
}

// Every pixel sees the same.
std::vector<ImageRegion> Everywhere(int width, int height) {
  return RegionsOf({}, AnglesDeg(0, 60, 180, 60), width, height, kPi / 2);
}
const std::vector<ImageRegion> kRegions = Everywhere(8, 8);

// All frames of a pose that starts with `first`.
std::vector<Exposure> Bracket(const Rgb& rates, Seconds first, const RigConfig& rig) {
  std::vector<Exposure> taken;
  std::optional<Seconds> next = first;
  while (next && taken.size() < 50) {
    taken.push_back(Take(rates, *next, rig));
    next = NextExposure(taken, kRegions, rig);
  }
  return taken;
}

// Whether the channel is unsaturated and above the minimum in some frame.
bool Good(const std::vector<Exposure>& taken, int c, const RigConfig& rig) {
  return std::any_of(taken.begin(), taken.end(), [&](const Exposure& e) {
    return !e.saturated[c] && MeansOf(e.frame, rig.camera.full_scale, kRegions).counts[c] >=
                                  rig.exposure.min_fraction * rig.camera.full_scale;
  });
}

TEST(MeansOf, SubtractsTheBlackLevelAndCountsClippedPixels) {
  Frame frame{.width = 2, .height = 1, .counts = {}, .black_level = 10};
  frame.counts = {10, 4095, 100, 0, 4095, 4095};
  const FrameMeans means = MeansOf(frame, 4095, Everywhere(2, 1));
  EXPECT_EQ(means.counts[0], -5);
  EXPECT_EQ(means.counts[1], 4085);
  EXPECT_EQ(means.saturated_fraction[0], 0);
  EXPECT_EQ(means.saturated_fraction[1], 1);
  EXPECT_EQ(means.saturated_fraction[2], 0.5);
}

TEST(MeansOf, LooksAtThePixelsOfItsRegionsOnly) {
  Frame frame{.width = 3, .height = 1, .counts = {}, .black_level = 10};
  frame.counts = {4095, 4095, 4095, 20, 30, 40, 40, 50, 60};
  const std::vector<ImageRegion> regions(2, ImageRegion{{}, {1}, {}, 1});
  const FrameMeans means = MeansOf(frame, 4095, {regions.data(), 1});
  EXPECT_TRUE((means.counts == Rgb(10, 20, 30)).all());
  EXPECT_TRUE((means.pixels == Rgb::Ones()).all());
}

// Example failure is a mosaic read as if its colours were interleaved.
TEST(MeansOf, KnowsWhatAPixelOfAMosaicSees) {
  Frame frame{.width = 4, .height = 2, .layout = PixelLayout::kBayerGr, .counts = {}};
  frame.counts = {10, 1,  30, 3,    // green, red
                  5,  20, 7,  40};  // blue, green
  const FrameMeans means = MeansOf(frame, 4095, Everywhere(4, 2));
  EXPECT_TRUE((means.counts == Rgb(2, 25, 6)).all());
  EXPECT_TRUE((means.pixels == Rgb(2, 4, 2)).all());
  frame.layout = PixelLayout::kMono;
  EXPECT_TRUE((MeansOf(frame, 4095, Everywhere(4, 2)).counts == Rgb::Constant(14.5)).all());
}

TEST(FirstExposure, AimsTheBrightestChannelAtTheTarget) {
  const RigConfig rig = DefaultRig();
  EXPECT_NEAR(FirstExposure({1000, 8190, 20}, rig).count(), 0.3, 1e-9);
}

TEST(FirstExposure, StaysInsideTheCamerasRangeAndTheSoftLimit) {
  const RigConfig rig = DefaultRig();
  EXPECT_EQ(FirstExposure(Rgb::Constant(1e12), rig), rig.camera.min_exposure);
  EXPECT_EQ(FirstExposure(Rgb::Constant(1e-3), rig), rig.exposure.soft_limit);
  EXPECT_EQ(FirstExposure(Rgb::Zero(), rig), rig.exposure.soft_limit);
  EXPECT_EQ(FirstExposure(Rgb::Constant(-5), rig), rig.exposure.soft_limit);
  EXPECT_EQ(FirstExposure(Rgb::Constant(std::nan("")), rig), rig.exposure.soft_limit);
}

TEST(NextExposure, OneFrameIsEnoughForAWellPredictedPose) {
  const RigConfig rig = DefaultRig();
  const Rgb rates = {3000, 8000, 2000};
  EXPECT_EQ(Bracket(rates, FirstExposure(rates, rig), rig).size(), 1);
}

TEST(NextExposure, MakesEveryChannelGoodFromAnyStartInFewFrames) {
  const RigConfig rig = DefaultRig();
  for (const double rate : {30.0, 1e3, 1e4, 1e5, 1e6, 1e7, 5e7}) {
    for (const double start : {20e-6, 1e-3, 0.3, 1.0}) {
      for (const Rgb& colour : {Rgb(1, 1, 1), Rgb(1, 0.3, 0.1), Rgb(0.02, 1, 0.3)}) {
        // What the longest exposure leaves in the dark is not the subject.
        if (rate * colour.minCoeff() * 10 < 0.006 * 4095) continue;
        const auto taken = Bracket(rate * colour, Seconds(start), rig);
        EXPECT_LE(taken.size(), 8) << rate << " " << start << " " << colour.transpose();
        for (int c = 0; c < kChannels; ++c) {
          EXPECT_TRUE(Good(taken, c, rig)) << rate << " " << start << " " << c;
        }
      }
    }
  }
}

TEST(NextExposure, ShortensByHowMuchIsClipped) {
  const RigConfig rig = DefaultRig();
  const auto after = [&](const Exposure& taken) {
    return NextExposure(std::vector{taken}, kRegions, rig)->count();
  };
  Exposure all = Take(Rgb::Constant(1e6), Seconds(0.32), rig);
  EXPECT_DOUBLE_EQ(after(all), 0.02);
  EXPECT_DOUBLE_EQ(after(Take({1e6, 1e3, 1e3}, Seconds(0.32), rig)), 0.08);
  // One pixel of one channel.
  Exposure speck = Take(Rgb::Constant(5e3), Seconds(0.32), rig);
  speck.frame.counts[0] = 4095;
  speck.saturated[0] = true;
  EXPECT_DOUBLE_EQ(after(speck), 0.16);
}

TEST(NextExposure, KeepsAChannelThatSaturatesInTheLongFrame) {
  const RigConfig rig = DefaultRig();
  const Rgb rates = {40000, 100, 4000};
  const auto taken = Bracket(rates, FirstExposure(rates, rig), rig);
  ASSERT_EQ(taken.size(), 2);
  EXPECT_FALSE(taken[0].saturated[0]);
  EXPECT_TRUE(taken[1].saturated[0]);
  EXPECT_TRUE(Good(taken, 1, rig));
}

TEST(NextExposure, DoesNotSpendTenSecondsToReachTheTargetInTheDark) {
  const RigConfig rig = DefaultRig();
  const auto taken = Bracket(Rgb::Constant(25), Seconds(0.3), rig);
  double total = 0;
  for (const Exposure& e : taken) total += e.frame.exposure.count();
  EXPECT_LT(total, 2);
}

TEST(NextExposure, GivesUpAtTheEndsOfTheRange) {
  const RigConfig rig = DefaultRig();
  const auto mirror = Bracket(Rgb::Constant(1e12), Seconds(0.3), rig);
  EXPECT_EQ(mirror.back().frame.exposure, rig.camera.min_exposure);
  EXPECT_LE(mirror.size(), 6);
  const auto dark = Bracket(Rgb::Zero(), Seconds(0.3), rig);
  EXPECT_EQ(dark.back().frame.exposure, rig.camera.max_exposure);
  EXPECT_LE(dark.size(), 6);
}

TEST(NextExposure, EndsOnAnyScene) {
  const RigConfig rig = DefaultRig();
  for (int r = -3; r < 12; r += 3) {
    for (int g = -3; g < 12; g += 2) {
      for (double start = 20e-6; start <= 10; start *= 7) {
        const Rgb rates(std::pow(10, r), std::pow(10, g), 1e3);
        EXPECT_LT(Bracket(rates, Seconds(start), rig).size(), 16) << rates.transpose();
      }
    }
  }
}

}  // namespace
}  // namespace gonio
