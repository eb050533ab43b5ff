// SPDX-License-Identifier: Apache-2.0
#include "brdf/render/sphere.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "brdf/analytic.h"
#include "brdf/render/half_vector_sampler.h"
#include "core/error.h"
#include "core/units.h"
#include "tests/brdf/function_brdf.h"

namespace gonio {
namespace {

FunctionBrdf White() {
  return FunctionBrdf([](const HalfDiff&) { return Rgb::Constant(1 / kPi); });
}

AnalyticBrdf Gloss(double roughness) {
  return AnalyticBrdf("gloss", {Lambert{{0.2, 0.3, 0.4}}, Ggx{.roughness = roughness, .ior = 1.5}});
}

Environment Constant() {
  Image image(32, 16);
  for (Eigen::Array3f& pixel : image.pixels) pixel.setOnes();
  return Environment(std::move(image));
}

// The mean over pixels well inside the sphere.
Eigen::Array3d Inside(const Image& image) {
  Eigen::Array3d sum = Eigen::Array3d::Zero();
  int count = 0;
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      if (std::hypot(x + 0.5 - image.width / 2.0, y + 0.5 - image.height / 2.0) >
          0.4 * image.width) {
        continue;
      }
      sum += image.at(x, y).cast<double>();
      ++count;
    }
  }
  return sum / count;
}

TEST(Sphere, LooksLikeItsSurroundingsIfWhite) {
  const Image image = RenderUnder(White(), Constant(), {.size = 32, .samples = 300});
  EXPECT_NEAR(Inside(image)[0], 1, 0.005);
  EXPECT_NEAR(image.at(16, 16)[1], 1, 0.05);
  EXPECT_EQ(image.at(0, 0).maxCoeff(), 0);  // beside the sphere
}

// Seen head on, in the middle of the sphere, the furnace shows the directional albedo at 0 degrees.
TEST(Sphere, ShowsTheAlbedoInAFurnace) {
  for (const double roughness : {0.08, 0.4}) {
    const AnalyticBrdf brdf = Gloss(roughness);
    Rgb albedo = Rgb::Zero();
    constexpr int kSteps = 2000;
    for (int i = 0; i < kSteps; ++i) {
      // theta_i at the normal; by reciprocity the integral over wo with its cosine.
      const double u = (i + 0.5) / kSteps;
      const double theta = kPi / 2 * u * u;  // dense at the highlight
      const Rgb f_r = *brdf.Eval(DirectionPair{Eigen::Vector3d::UnitZ(), FromSpherical(theta, 1)});
      albedo += 2 * kPi * f_r * std::cos(theta) * std::sin(theta) * kPi * u / kSteps;
    }
    const Image image = RenderUnder(brdf, Constant(), {.size = 33, .samples = 3000});
    EXPECT_LT((image.at(16, 16).cast<double>() - albedo).abs().maxCoeff(), 0.02) << roughness;
  }
}

TEST(Sphere, FollowsTheCosineUnderAPointLight) {
  const Eigen::Vector3d light = Eigen::Vector3d(0.3, 0.2, 0.9).normalized();
  const Image image = RenderUnderPoint(White(), {.size = 200}, light);
  for (const auto& [x, y] : {std::pair{100, 100}, {140, 60}, {60, 130}}) {
    const double nx = (x + 0.5 - 100) / 92;
    const double ny = (100 - y - 0.5) / 92;
    const Eigen::Vector3d normal(nx, ny, std::sqrt(1 - nx * nx - ny * ny));
    EXPECT_NEAR(image.at(x, y)[2], std::max(0.0, normal.dot(light)), 1e-3);
  }
}

TEST(Sphere, IsLitFromWhereTheLightIs) {
  Image right(32, 16);
  for (int y = 0; y < 16; ++y) right.at(24, y).setConstant(10);
  const Image image = RenderUnder(Gloss(0.3), Environment(right), {.size = 48, .samples = 96});
  EXPECT_GT(image.at(42, 24)[0], 5 * image.at(6, 24)[0]);
}

TEST(Sphere, IsTheSameForAnyNumberOfThreads) {
  const Environment sky = Environment::Sky();
  const Image one = RenderUnder(Gloss(0.2), sky, {.size = 24, .samples = 30, .threads = 1});
  const Image two = RenderUnder(Gloss(0.2), sky, {.size = 24, .samples = 30, .threads = 2});
  for (std::size_t i = 0; i < one.pixels.size(); ++i) {
    ASSERT_TRUE((one.pixels[i] == two.pixels[i]).all());
  }
}

TEST(Sphere, IsBlackWhereNothingIsKnown) {
  const FunctionBrdf unknown([](const HalfDiff&) { return std::optional<Rgb>(); });
  EXPECT_EQ(Inside(RenderUnderPoint(unknown, {.size = 32})).maxCoeff(), 0);
}

TEST(Sphere, RefusesOptionsOutOfRange) {
  EXPECT_THROW(RenderUnderPoint(White(), {.size = 8}), ConfigError);
  EXPECT_THROW(RenderUnder(White(), Constant(), {.samples = 0}), ConfigError);
}

class HalfVectors : public testing::TestWithParam<double> {};
INSTANTIATE_TEST_SUITE_P(Roughness, HalfVectors, testing::Values(0.02, 0.2, 0.9));

TEST_P(HalfVectors, HaveADensityThatIntegratesToOneAndIsDrawnFrom) {
  const HalfVectorSampler sampler{Gloss(GetParam())};
  double sum = 0;
  double near = 0;  // within 5 degrees
  constexpr int kSteps = 40000;
  for (int i = 0; i < kSteps; ++i) {
    const double u = (i + 0.5) / kSteps;
    const double theta = kPi / 2 * u * u;
    const double share =
        sampler.Pdf(FromSpherical(theta, 0)) * 2 * kPi * std::sin(theta) * kPi * u / kSteps;
    sum += share;
    if (theta < RadFromDeg(5)) near += share;
  }
  EXPECT_NEAR(sum, 1, 1e-3);
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> uniform(0, 1);
  int drawn = 0;
  constexpr int kDraws = 20000;
  for (int i = 0; i < kDraws; ++i) {
    const Eigen::Vector3d half = sampler.Draw(uniform(random), uniform(random));
    drawn += half.z() > std::cos(RadFromDeg(5));
  }
  EXPECT_NEAR(drawn / double{kDraws}, near, 4 * std::sqrt(near * (1 - near) / kDraws) + 2e-3);
}

}  // namespace
}  // namespace gonio
