// SPDX-License-Identifier: Apache-2.0
#include "sim/sim_camera.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numeric>

#include "core/units.h"
#include "tests/brdf/function_brdf.h"

namespace gonio {
namespace {

// Light 60 deg from the normal, camera on the normal; 1000 electrons per second at f_r = 1.
struct Bench {
  explicit Bench(const SimConfig& config, double f_r = 1, int side = 8)
      : Bench(
            config, [f_r](const HalfDiff&) { return Rgb(f_r, f_r / 2, f_r / 4); }, side) {}
  Bench(const SimConfig& config, BrdfFunction function, int side = 8)
      : sample(std::move(function)), lamp(std::make_shared<SimLamp>(0)) {
    lamp->set_level(1);
    const double positions[4] = {0.3, RadFromDeg(30), 2, kPi / 2};
    for (int i = 0; i < 4; ++i) {
      motors[i] = std::make_shared<SimMotor>(positions[i], 1.0, 1.0, clock);
    }
    const CameraInfo info = {.width = side,
                             .height = side,
                             .min_exposure = Seconds(1e-5),
                             .max_exposure = Seconds(20),
                             .readout = Seconds(0.25)};
    camera = std::make_unique<SimCamera>("camera", info, config, sample,
                                         std::make_unique<MotorScene>(motors, lamp), clock,
                                         Random(1, 1));
  }

  Frame Capture(double exposure_s) { return camera->Capture(Seconds(exposure_s), {}).value(); }

  ManualClock clock;
  FunctionBrdf sample;
  SimMotors motors;
  std::shared_ptr<SimLamp> lamp;
  std::unique_ptr<SimCamera> camera;
};

SimConfig Ideal() {
  SimConfig config;
  config.responsivity = Rgb::Constant(1000);
  return config;
}

struct Moments {
  double mean = 0;
  double variance = 0;
};
Moments ChannelMoments(const Frame& frame, int c) {
  double sum = 0;
  double squares = 0;
  for (std::size_t i = c; i < frame.counts.size(); i += kChannels) {
    sum += frame.counts[i];
    squares += std::pow(frame.counts[i], 2);
  }
  const double n = static_cast<double>(frame.counts.size()) / kChannels;
  return {sum / n, squares / n - std::pow(sum / n, 2)};
}

TEST(SimCamera, IsExactWithoutImperfections) {
  Bench bench(Ideal());
  const Frame frame = bench.Capture(1);
  ASSERT_EQ(frame.counts.size(), 8 * 8 * 3);
  // 1000 /s * f_r * cos 60 deg * 1 s.
  for (std::size_t i = 0; i < frame.counts.size(); i += 3) {
    EXPECT_EQ(frame.counts[i], 500);
    EXPECT_EQ(frame.counts[i + 1], 250);
    EXPECT_EQ(frame.counts[i + 2], 125);
  }
}

TEST(SimCamera, AddsBlackLevelAndDividesByTheGain) {
  SimConfig config = Ideal();
  config.black_level = 64;
  config.electrons_per_count = 4;
  Bench bench(config);
  const Frame frame = bench.Capture(1);
  EXPECT_EQ(frame.black_level, 64);
  EXPECT_EQ(frame.counts[0], 64 + 125);
}

TEST(SimCamera, FollowsPowerAndExposure) {
  Bench bench(Ideal());
  bench.lamp->set_level(0.5);
  EXPECT_EQ(bench.Capture(2).counts[0], 500);
  bench.lamp->set_level(0);
  EXPECT_EQ(bench.Capture(2).counts[0], 0);
}

TEST(SimCamera, ClipsAtFullScale) {
  Bench bench(Ideal(), 100);
  EXPECT_EQ(bench.Capture(1).counts[0], 4095);
}

TEST(SimCamera, RefusesWhereTheReflectanceIsUnknown) {
  Bench bench(Ideal(), [](const HalfDiff&) { return std::nullopt; });
  const auto frame = bench.camera->Capture(Seconds(1), {});
  ASSERT_FALSE(frame.ok());
  EXPECT_EQ(frame.error().code, ErrorCode::kRefused);
  EXPECT_EQ(frame.error().message,
            "camera: function is unknown at theta_i 60.00, theta_o 0.00 deg");
}

TEST(SimCamera, TakesTheTimeOfExposureAndReadout) {
  Bench bench(Ideal());
  bench.clock.SleepFor(Seconds(3));
  const Frame frame = bench.Capture(0.5);
  EXPECT_EQ(frame.start, Seconds(3));
  EXPECT_DOUBLE_EQ(bench.clock.Now().count(), 3.75);
}

TEST(SimCamera, RoundsTheExposureToItsStepAndSaysSo) {
  Bench bench(Ideal());
  EXPECT_DOUBLE_EQ(bench.Capture(0.1234567).exposure.count(), 0.123457);
}

TEST(SimCamera, ShotNoiseHasTheVarianceOfTheElectrons) {
  SimConfig config = Ideal();
  config.shot_noise = true;
  Bench bench(config, 1, 200);
  const Moments moments = ChannelMoments(bench.Capture(1), 0);
  EXPECT_NEAR(moments.mean, 500, 0.5);
  EXPECT_NEAR(moments.variance, 500, 15);
}

TEST(SimCamera, DarkCurrentAddsElectronsAndTheirNoise) {
  SimConfig config = Ideal();
  config.shot_noise = true;
  config.dark_current = 100;
  Bench bench(config, 0, 200);
  const Moments moments = ChannelMoments(bench.Capture(2), 0);
  EXPECT_NEAR(moments.mean, 200, 0.3);
  EXPECT_NEAR(moments.variance, 200, 6);
}

TEST(SimCamera, LosesWhatAPixelCannotHold) {
  SimConfig config = Ideal();
  config.black_level = 10;
  config.full_well = 300;
  Bench bench(config);
  EXPECT_EQ(bench.Capture(0.5).counts[0], 10 + 250);
  EXPECT_EQ(bench.Capture(1).counts[0], 10 + 300);
  EXPECT_EQ(bench.Capture(15).counts[0], 10 + 300);
  config.full_well = 0;
  EXPECT_EQ(Bench(config).Capture(15).counts[0], 4095);
}

TEST(SimCamera, ReadNoiseIsPerPixelWhateverTheExposure) {
  SimConfig config = Ideal();
  config.read_noise = 10;
  config.black_level = 100;
  Bench bench(config, 0, 200);
  for (const double exposure : {0.001, 5.0}) {
    const Moments moments = ChannelMoments(bench.Capture(exposure), 0);
    EXPECT_NEAR(moments.mean, 100, 0.2);
    EXPECT_NEAR(moments.variance, 100, 3);
  }
}

TEST(SimCamera, MultiplicativeNoiseIsCommonToAChannelsPixels) {
  SimConfig config = Ideal();
  config.multiplicative_noise = 0.02;
  Bench bench(config, 4, 2);
  double squares = 0;
  int channels_agree = 0;
  constexpr int kFrames = 4000;
  for (int i = 0; i < kFrames; ++i) {
    const Frame frame = bench.Capture(1);
    EXPECT_EQ(ChannelMoments(frame, 0).variance, 0);
    squares += std::pow(frame.counts[0] / 2000.0 - 1, 2);
    if (std::abs(frame.counts[0] / 2.0 - frame.counts[1]) < 1) ++channels_agree;
  }
  EXPECT_NEAR(std::sqrt(squares / kFrames), 0.02, 0.001);
  EXPECT_LT(channels_agree, kFrames / 10);
}

TEST(SimCamera, SmearsWhatMovesWhileTheShutterIsOpen) {
  // Bright only within 5 deg of theta_h = 30 deg, where the arms stand at first.
  const auto lobe = [](const HalfDiff& angles) {
    const bool inside = std::abs(angles.theta_h - RadFromDeg(30)) < RadFromDeg(5);
    return Rgb(Rgb::Constant(inside ? 1 : 0));
  };
  Bench still(Ideal(), lobe);
  EXPECT_EQ(still.Capture(1).counts[0], 500);
  Bench moving(Ideal(), lobe);
  moving.motors[1]->Start(RadFromDeg(80));
  const int smeared = moving.Capture(1).counts[0];
  EXPECT_GT(smeared, 50);
  EXPECT_LT(smeared, 450);
}

TEST(SimCamera, RefusesExposuresOutsideItsRange) {
  Bench bench(Ideal());
  for (const double exposure : {0.0, 1e-6, 21.0, -1.0, std::nan("")}) {
    const auto frame = bench.camera->Capture(Seconds(exposure), {});
    ASSERT_FALSE(frame.ok());
    EXPECT_EQ(frame.error().code, ErrorCode::kRefused);
  }
  EXPECT_EQ(bench.camera->Capture(Seconds(21), {}).error().message,
            "camera: exposure of 21 s: outside 1e-05 .. 20 s");
}

}  // namespace
}  // namespace gonio
