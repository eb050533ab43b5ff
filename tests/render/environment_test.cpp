// SPDX-License-Identifier: Apache-2.0
#include "brdf/render/environment.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>

#include "core/error.h"
#include "core/units.h"
#include "tests/core/temp_dir.h"

namespace gonio {
namespace {

using testing::HasSubstr;

// Bright to the right (+x), dim elsewhere.
Image RightSide() {
  Image image(16, 8);
  for (int y = 0; y < 8; ++y) {
    for (int x = 0; x < 16; ++x) image.at(x, y).setConstant(x == 12 ? 5.0f : 0.1f);
  }
  return image;
}

TEST(Environment, KnowsItsDirections) {
  const Environment environment(RightSide());
  EXPECT_EQ(environment.Radiance(Eigen::Vector3d(1, 0.01, 0.01).normalized())[0], 5);
  EXPECT_EQ(environment.Radiance(-Eigen::Vector3d::UnitX())[0], 0.1f);
  Image top(16, 8);
  for (int x = 0; x < 16; ++x) top.at(x, 0).setConstant(3);
  EXPECT_EQ(Environment(top).Radiance(Eigen::Vector3d::UnitY())[1], 3);
  Image centre(16, 8);
  centre.at(8, 4).setConstant(2);
  EXPECT_EQ(Environment(centre).Radiance(Eigen::Vector3d(0.01, -0.01, -1).normalized())[1], 2);
}

TEST(Environment, ItsDensityIntegratesToOne) {
  for (const Environment& environment : {Environment(RightSide()), Environment::Sky()}) {
    double sum = 0;
    constexpr int kSteps = 600;
    for (int i = 0; i < kSteps; ++i) {
      const double polar = kPi * (i + 0.5) / kSteps;
      for (int j = 0; j < 2 * kSteps; ++j) {
        const double azimuth = kPi * (j + 0.5) / kSteps;
        sum += environment.Pdf({std::sin(polar) * std::cos(azimuth), std::cos(polar),
                                std::sin(polar) * std::sin(azimuth)}) *
               std::sin(polar);
      }
    }
    EXPECT_NEAR(sum * kPi / kSteps * kPi / kSteps, 1, 0.01);
  }
}

TEST(Environment, DrawsWithItsDensity) {
  const Environment environment(RightSide());
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> uniform(0, 1);
  int right = 0;
  constexpr int kDraws = 20000;
  for (int i = 0; i < kDraws; ++i) {
    const Environment::Sample sample = environment.Draw(uniform(random), uniform(random));
    EXPECT_NEAR(sample.direction.norm(), 1, 1e-9);
    EXPECT_NEAR(sample.pdf, environment.Pdf(sample.direction), 1e-9);
    right += environment.Radiance(sample.direction)[0] > 1;
  }
  const double share = 5.0 / (5 + 15 * 0.1);
  EXPECT_NEAR(right / double{kDraws}, share, 4 * std::sqrt(share * (1 - share) / kDraws));
}

TEST(Environment, SkyLightsAHorizontalWhiteSurfaceToOne) {
  const Environment sky = Environment::Sky();
  double irradiance = 0;
  constexpr int kSteps = 1000;
  for (int i = 0; i < kSteps; ++i) {
    const double polar = kPi / 2 * (i + 0.5) / kSteps;
    for (int j = 0; j < kSteps; ++j) {
      const double azimuth = 2 * kPi * (j + 0.5) / kSteps;
      const Eigen::Array3f radiance =
          sky.Radiance({std::sin(polar) * std::cos(azimuth), std::cos(polar),
                        std::sin(polar) * std::sin(azimuth)});
      irradiance += (0.2126 * radiance[0] + 0.7152 * radiance[1] + 0.0722 * radiance[2]) *
                    std::cos(polar) * std::sin(polar);
    }
  }
  EXPECT_NEAR(irradiance * kPi / 2 / kSteps * 2 * kPi / kSteps / kPi, 1, 0.02);
}

TEST(Environment, ReadsAFileOrSaysWhyNot) {
  const TempDir dir;
  WriteImage(dir / "e.exr", RightSide());
  EXPECT_NEAR(
      Environment::Read(dir / "e.exr").Radiance(Eigen::Vector3d(1, 0.01, 0.01).normalized())[0], 5,
      1e-4);
  const auto message = [&](const Image& image) {
    WriteImage(dir / "bad.exr", image);
    return MessageOf<ConfigError>([&] { Environment::Read(dir / "bad.exr"); });
  };
  EXPECT_THAT(message(Image(8, 8)), HasSubstr("bad.exr: has 8 x 8 pixels, must be twice as wide"));
  EXPECT_THAT(message(Image(8, 4)), HasSubstr("bad.exr: is black"));
  Image negative = RightSide();
  negative.at(0, 0)[2] = -1;
  EXPECT_THAT(message(negative), HasSubstr("negative radiance"));
}

}  // namespace
}  // namespace gonio
