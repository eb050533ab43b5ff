// SPDX-License-Identifier: Apache-2.0
#include "sim/sim_optics.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numeric>

#include "brdf/analytic.h"
#include "core/units.h"
#include "tests/brdf/function_brdf.h"

namespace gonio {
namespace {

constexpr int kSide = 101;  // odd: a pixel's middle is on the axis
constexpr int kMiddle = kSide / 2;

const FunctionBrdf kGrey([](const HalfDiff&) { return Rgb(Rgb::Constant(0.3)); });

Imaging Flat() {
  return {.focal_length = 2000, .camera_distance = 0.5, .light_distance = 0.8, .shape = {}};
}
Imaging Curved(SampleShape::Kind kind) {
  Imaging imaging = Flat();
  imaging.shape = {kind, 0.01};
  return imaging;
}

SimArms Degrees(double light_azimuth, double light_elevation, double camera_azimuth,
                double camera_elevation) {
  return {RadFromDeg(light_azimuth), RadFromDeg(light_elevation), RadFromDeg(camera_azimuth),
          RadFromDeg(camera_elevation)};
}

SimOptics Optics(const Imaging& imaging, const SimConfig& truth = {}, int side = kSide) {
  return {truth, imaging, side, side};
}

SimImage Render(const Imaging& imaging, const SimArms& arms, const Brdf& sample,
                const SimConfig& truth = {}, int side = kSide) {
  return Optics(imaging, truth, side).Render(arms, 1, sample, {0, 0, side, side}, true);
}

float At(const SimImage& image, int x, int y) {
  return image.values[static_cast<std::size_t>(y) * image.width + x];
}

void ExpectSame(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  EXPECT_LT((a - b).norm(), 1e-12) << a.transpose() << " and " << b.transpose();
}

TEST(SimOptics, TheMiddleSeesTheArmsDirections) {
  const SimArms arms = Degrees(20, 40, 170, 65);
  const DirectionPair pair = Place(SimRigKind::kFourAxisArms, arms).directions();
  for (const auto kind :
       {SampleShape::Kind::kFlat, SampleShape::Kind::kSphere, SampleShape::Kind::kCylinder}) {
    const auto view = Optics(Curved(kind)).See(arms, kMiddle, kMiddle);
    ASSERT_TRUE(view);
    ExpectSame(view->local.wi, pair.wi);
    ExpectSame(view->local.wo, pair.wo);
    EXPECT_NEAR(view->inverse_square, 1, 1e-12);
  }
}

// The camera looks straight down from 0.5 m at azimuth 0: right is +y, down is +x. 40 px of 2000
// are 0.01 m on the plane.
TEST(SimOptics, APlanesPixelsSeeDirectionsFoundByHand) {
  const auto view = Optics(Flat()).See(Degrees(0, 90, 0, 90), kMiddle + 40, kMiddle + 20);
  ASSERT_TRUE(view);
  ExpectSame(view->point, {0.005, 0.01, 0});
  ExpectSame(view->local.wo, Eigen::Vector3d(-0.005, -0.01, 0.5).normalized());
  ExpectSame(view->local.wi, Eigen::Vector3d(-0.005, -0.01, 0.8).normalized());
  EXPECT_NEAR(view->inverse_square, 0.64 / (0.64 + 1.25e-4), 1e-12);
}

// What lies on the side of growing azimuth is on the right, what is nearer to the camera's foot is
// below. Example failure is a mirrored image, which calibration would accept.
TEST(SimOptics, RightIsTheSideOfGrowingAzimuthAndDownIsNear) {
  const SimOptics optics = Optics(Flat());
  const SimArms arms = Degrees(200, 45, 30, 45);
  const Eigen::Vector3d foot(std::cos(RadFromDeg(30)), std::sin(RadFromDeg(30)), 0);
  const Eigen::Vector3d growing(-foot.y(), foot.x(), 0);
  EXPECT_GT(optics.See(arms, kMiddle + 10, kMiddle)->point.dot(growing), 0.001);
  EXPECT_GT(optics.See(arms, kMiddle, kMiddle + 10)->point.dot(foot), 0.001);
}

TEST(SimOptics, ASpheresHighlightLeansTowardsTheLight) {
  const FunctionBrdf shiny([](const HalfDiff& a) {
    return Rgb(Rgb::Constant(std::exp(-std::pow(a.theta_h / 0.05, 2))));
  });
  // The camera above at azimuth 0 has +y on the right; the light is at +y.
  const SimImage image = Render(Curved(SampleShape::Kind::kSphere), Degrees(90, 50, 0, 90), shiny);
  const auto brightest = std::max_element(image.values.begin(), image.values.end());
  const auto i = static_cast<int>(brightest - image.values.begin());
  EXPECT_GT(i % kSide, kMiddle + 5);
  EXPECT_NEAR(i / kSide, kMiddle, 1);
  EXPECT_GT(*brightest, 0.5);
}

// From above at distance D over the top, a ray at angle t to the axis passes the centre at
// (D + R) sin t; on the sphere's normal that is an angle a with R sin(a + t) = (D + R) sin t.
TEST(SimOptics, ASpheresNormalsAreThoseOfThePlaneGeometry) {
  const SimOptics optics = Optics(Curved(SampleShape::Kind::kSphere));
  const SimArms arms = Degrees(0, 60, 0, 90);
  for (const int offset : {5, 20, 35}) {
    const double t = std::atan(offset / 2000.0);
    const double polar = std::asin(0.51 * std::sin(t) / 0.01) - t;
    const auto view = optics.See(arms, kMiddle + offset, kMiddle);
    ASSERT_TRUE(view);
    ExpectSame(view->normal, {0, std::sin(polar), std::cos(polar)});
    EXPECT_NEAR(view->local.cos_theta_o(), std::cos(polar + t), 1e-9);
    EXPECT_NEAR(view->normal.dot(view->tangent), 0, 1e-12);
  }
  // The silhouette: sin t = R / (D + R), at 39.2 px.
  EXPECT_TRUE(optics.See(arms, kMiddle + 39.1, kMiddle));
  EXPECT_FALSE(optics.See(arms, kMiddle + 39.3, kMiddle));
}

TEST(SimOptics, ACylinderIsRoundAcrossItsAxisAndFlatAlongIt) {
  const SimOptics optics = Optics(Curved(SampleShape::Kind::kCylinder));
  const SimArms arms = Degrees(0, 60, 0, 90);
  const double t = std::atan(20 / 2000.0);
  const double polar = std::asin(0.51 * std::sin(t) / 0.01) - t;
  const auto across = optics.See(arms, kMiddle + 20, kMiddle);
  ASSERT_TRUE(across);
  ExpectSame(across->normal, {0, std::sin(polar), std::cos(polar)});
  ExpectSame(across->tangent, Eigen::Vector3d::UnitX());
  const auto along = optics.See(arms, kMiddle, kMiddle + 40);
  ASSERT_TRUE(along);
  ExpectSame(along->point, {0.01, 0, 0});
  ExpectSame(along->normal, Eigen::Vector3d::UnitZ());
}

// Down at azimuth 0 is +x, the cylinder's axis. 0.5 m / 2000 px are 0.25 mm per pixel.
TEST(SimOptics, TheSampleEndsAtItsRadius) {
  SimConfig truth;
  truth.sample_radius = 0.005;
  for (const auto kind : {SampleShape::Kind::kFlat, SampleShape::Kind::kCylinder}) {
    const SimOptics optics = Optics(Curved(kind), truth);
    EXPECT_TRUE(optics.See(Degrees(0, 60, 0, 90), kMiddle, kMiddle + 19));
    EXPECT_FALSE(optics.See(Degrees(0, 60, 0, 90), kMiddle, kMiddle + 21));
  }
}

TEST(SimOptics, ADiscIsForeshortened) {
  SimConfig truth;
  truth.sample_radius = 0.01;
  truth.every_px = 1;
  const auto area = [&](double elevation) {
    const SimImage image = Render(Flat(), Degrees(180, 60, 0, elevation), kGrey, truth);
    return std::count_if(image.values.begin(), image.values.end(), [](float v) { return v > 0; });
  };
  EXPECT_NEAR(static_cast<double>(area(90)), kPi * 40 * 40, 50);
  EXPECT_NEAR(static_cast<double>(area(30)) / static_cast<double>(area(90)), 0.5, 0.01);
}

// Radiance does not depend on the camera's distance; irradiance falls with the light's cosine.
TEST(SimOptics, TheMiddleIsAsBrightAsTheArmsPair) {
  for (const double distance : {0.3, 3.0}) {
    Imaging imaging = Flat();
    imaging.camera_distance = distance;
    const SimImage image = Render(imaging, Degrees(0, 30, 180, 60), kGrey);
    EXPECT_NEAR(At(image, kMiddle, kMiddle), 0.3 * 0.5, 1e-4);
  }
}

// The light is moved out by a tenth of its distance.
TEST(SimOptics, LightFallsWithTheSquareOfItsDistance) {
  SimConfig truth;
  truth.light_offset = {0, 0, 0.08};
  EXPECT_NEAR(At(Render(Flat(), Degrees(0, 90, 0, 90), kGrey, truth), kMiddle, kMiddle), 0.3 / 1.21,
              1e-4);
}

// Sideways it shines from atan(0.1): right of a light above at azimuth 0 is +y.
TEST(SimOptics, AnOffsetOfTheLightTurnsItsDirection) {
  SimConfig truth;
  truth.light_offset = {0.08, 0, 0};
  const auto view = Optics(Flat(), truth).See(Degrees(0, 90, 0, 90), kMiddle, kMiddle);
  ExpectSame(view->local.wi, Eigen::Vector3d(0, 0.1, 1).normalized());
}

TEST(SimOptics, WhatTurnsAwayFromTheLightIsDark) {
  const Imaging imaging = Curved(SampleShape::Kind::kSphere);
  const SimArms arms = Degrees(90, 20, 0, 90);
  const SimImage image = Render(imaging, arms, kGrey);
  EXPECT_LT(Optics(imaging).See(arms, kMiddle - 30, kMiddle)->local.cos_theta_i(), 0);
  EXPECT_EQ(At(image, kMiddle - 30, kMiddle), 0);
  EXPECT_GT(At(image, kMiddle + 30, kMiddle), 0.2);
}

TEST(SimOptics, VignettingFollowsTheFourthPowerOfTheCosine) {
  Imaging imaging = Flat();
  imaging.focal_length = 100;
  imaging.light_distance = std::numeric_limits<double>::infinity();
  SimConfig truth;
  truth.vignetting = 0.5;
  truth.every_px = 1;
  const SimImage image = Render(imaging, Degrees(0, 90, 0, 90), kGrey, truth);
  EXPECT_NEAR(At(image, kMiddle + 50, kMiddle), 0.3 * (1 - 0.5 * (1 - std::pow(0.8, 2))), 1e-6);
}

TEST(SimOptics, DefocusBlursAnEdgeAndKeepsTheLight) {
  SimConfig truth;
  truth.sample_radius = 0.005;  // 20 px
  truth.every_px = 1;
  const SimArms arms = Degrees(0, 90, 0, 90);
  const SimImage sharp = Render(Flat(), arms, kGrey, truth);
  truth.defocus = 3;
  const SimImage soft = Render(Flat(), arms, kGrey, truth);
  EXPECT_EQ(At(sharp, kMiddle + 21, kMiddle), 0);
  EXPECT_NEAR(At(soft, kMiddle + 20, kMiddle) / At(sharp, kMiddle, kMiddle), 0.5, 0.1);
  const auto sum = [](const SimImage& image) {
    return std::accumulate(image.values.begin(), image.values.end(), 0.0);
  };
  EXPECT_NEAR(sum(soft) / sum(sharp), 1, 1e-3);
}

TEST(SimOptics, GlareIsAShareOfTheMean) {
  SimConfig truth;
  truth.sample_radius = 0.005;
  const SimArms arms = Degrees(0, 90, 0, 90);
  const SimImage clear = Render(Flat(), arms, kGrey, truth);
  truth.veiling_glare = 0.1;
  const SimImage hazy = Render(Flat(), arms, kGrey, truth);
  const double mean = std::accumulate(clear.values.begin(), clear.values.end(), 0.0) /
                      static_cast<double>(clear.values.size());
  EXPECT_NEAR(At(hazy, 0, 0), 0.1 * mean, 1e-6);
  EXPECT_NEAR(At(hazy, kMiddle, kMiddle), At(clear, kMiddle, kMiddle) + 0.1 * mean, 1e-6);
}

TEST(SimOptics, ARegionIsTheImageCutOut) {
  SimConfig truth;
  truth.defocus = 1;
  truth.every_px = 1;
  SimOptics optics = Optics(Curved(SampleShape::Kind::kSphere), truth);
  const SimArms arms = Degrees(30, 50, 200, 60);
  const SimImage whole = optics.Render(arms, 1, kGrey, {0, 0, kSide, kSide}, true);
  const SimImage part = optics.Render(arms, 1, kGrey, {30, 20, 25, 40}, true);
  for (int y = 0; y < 40; ++y) {
    for (int x = 0; x < 25; ++x) EXPECT_EQ(At(part, x, y), At(whole, 30 + x, 20 + y));
  }
}

TEST(SimOptics, ColoursAreApartAndMonochromeIsTheirMean) {
  const FunctionBrdf pink([](const HalfDiff&) { return Rgb(0.6, 0.3, 0.3); });
  SimConfig truth;
  truth.responsivity = Rgb(1, 2, 3);
  SimOptics optics = Optics(Flat(), truth);
  const SimRegion middle{kMiddle, kMiddle, 1, 1};
  const SimImage colour = optics.Render(Degrees(0, 90, 0, 90), 0.5, pink, middle, false);
  ASSERT_EQ(colour.values.size(), 3);
  EXPECT_FLOAT_EQ(colour.values[0], 0.3F);
  EXPECT_FLOAT_EQ(colour.values[1], 0.3F);
  EXPECT_FLOAT_EQ(colour.values[2], 0.45F);
  const SimImage mono = optics.Render(Degrees(0, 90, 0, 90), 0.5, pink, middle, true);
  EXPECT_FLOAT_EQ(mono.values.at(0), 0.35F);
}

// Satin paint with a dull and a sharp coat, in images where interpolation has something to win.
// Example failure is a highlight between the lattice's points that nobody looked at.
TEST(SimOptics, InterpolationErrsByLessThanAThousandth) {
  const int side = 256;
  SimConfig every;
  every.every_px = 1;
  every.sample_radius = 0.02;
  SimConfig some = every;
  some.every_px = 16;
  for (const double roughness : {0.01, 0.15}) {
    const AnalyticBrdf satin(
        "satin", {Lambert{Rgb(0.1, 0.3, 0.25)}, Ggx{.roughness = roughness, .ior = 1.5}});
    for (const auto kind :
         {SampleShape::Kind::kFlat, SampleShape::Kind::kSphere, SampleShape::Kind::kCylinder}) {
      Imaging imaging = Curved(kind);
      imaging.focal_length = 4000;
      const SimArms arms = Degrees(10, 50, 185, 60);
      const SimImage exact = Render(imaging, arms, satin, every, side);
      const SimImage quick = Render(imaging, arms, satin, some, side);
      double worst = 0;
      double brightest = 0;
      for (std::size_t i = 0; i < exact.values.size(); ++i) {
        brightest = std::max<double>(brightest, exact.values[i]);
        const double scale = std::max(exact.values[i], 0.01F);
        worst = std::max(worst, std::abs(quick.values[i] - exact.values[i]) / scale);
      }
      EXPECT_LT(worst, 1e-3) << static_cast<int>(kind) << ", roughness " << roughness;
      EXPECT_GT(brightest, 0.05);
    }
  }
}

TEST(SimOptics, WithoutImagingAllPixelsSeeTheArmsPair) {
  const SimImage image = Render({}, Degrees(0, 30, 180, 60), kGrey);
  EXPECT_EQ(image.planes, 0);
  EXPECT_NEAR(image.uniform[1], 0.15, 1e-12);
}

}  // namespace
}  // namespace gonio
