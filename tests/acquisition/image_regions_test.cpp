// SPDX-License-Identifier: Apache-2.0
#include "acquisition/image_regions.h"

#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "core/units.h"
#include "tests/acquisition/simulated_rig.h"

namespace gonio {
namespace {

constexpr double kMaxPolar = 86 * kPi / 180;

// A camera of 1000 px focal length 0.5 m away, a light 1 m away, a spot of 10 mm.
Imaging Camera(SampleShape shape = {}) {
  return {.focal_length = 1000,
          .camera_distance = 0.5,
          .light_distance = 1,
          .patch_radius = 0.01,
          .shape = shape};
}

std::set<std::uint32_t> PixelsOf(const std::vector<ImageRegion>& regions) {
  std::set<std::uint32_t> pixels;
  for (const ImageRegion& region : regions) {
    pixels.insert(region.pixels.begin(), region.pixels.end());
  }
  return pixels;
}

TEST(RegionsOf, SeesWhatTheArmsSayWithoutAFocalLength) {
  const auto regions = RegionsOf({}, AnglesDeg(10, 30, 170, 60), 8, 4, kMaxPolar);
  ASSERT_EQ(regions.size(), 1u);
  EXPECT_EQ(regions[0].pixels.size(), 32u);
  EXPECT_NEAR(regions[0].light, 0.5, 1e-12);
  EXPECT_NEAR(regions[0].directions.wo.z(), std::sin(RadFromDeg(60)), 1e-12);
}

// A disc of 10 mm radius is 20 px in radius from above; from 30 deg elevation half of that high.
TEST(RegionsOf, ForeshortensThePatch) {
  const auto above = RegionsOf(Camera(), AnglesDeg(0, 45, 0, 90), 64, 64, kMaxPolar);
  EXPECT_NEAR(above[0].pixels.size(), kPi * 20 * 20, 15);
  const auto oblique = RegionsOf(Camera(), AnglesDeg(0, 45, 0, 30), 64, 64, kMaxPolar);
  EXPECT_NEAR(oblique[0].pixels.size(), kPi * 20 * 10, 15);
  std::set<std::uint32_t> rows;
  for (const std::uint32_t pixel : oblique[0].pixels) rows.insert(pixel / 64);
  EXPECT_NEAR(rows.size(), 20, 1);
}

TEST(RegionsOf, AreAboutTheDirectionsOfTheArmsInTheMean) {
  const ArmAngles arms = AnglesDeg(20, 40, 175, 50);
  const auto regions = RegionsOf(Camera(), arms, 64, 64, kMaxPolar);
  ASSERT_EQ(regions.size(), 1u);
  const DirectionPair centre = RegionsOf({}, arms, 1, 1, kMaxPolar)[0].directions;
  EXPECT_LT(AngleBetween(regions[0].directions.wi, centre.wi), RadFromDeg(0.05));
  EXPECT_LT(AngleBetween(regions[0].directions.wo, centre.wo), RadFromDeg(0.05));
}

// By hand: the camera above, the light at 45 deg along +x. The point 8 mm along +x is nearer to the
// light; the camera looks at it from -x. With azimuth 0 the image's right is +y and its down is +x.
TEST(RegionsOf, GiveEachPixelItsOwnLightAndDirections) {
  Imaging imaging = Camera();
  imaging.patch_radius = 0.009;
  const auto regions = RegionsOf(imaging, AnglesDeg(0, 45, 0, 90), 65, 65, kMaxPolar);
  const double at = 0.008;
  const std::uint32_t pixel = (32 + 16) * 65 + 32;  // 16 px down
  const auto& pixels = regions[0].pixels;
  const auto found = std::find(pixels.begin(), pixels.end(), pixel);
  ASSERT_NE(found, pixels.end());
  const Eigen::Vector3d light(std::sqrt(0.5) - at, 0, std::sqrt(0.5));
  const double lit = light.normalized().z() / light.squaredNorm();
  EXPECT_NEAR(regions[0].lights[found - pixels.begin()], lit, 1e-6);
  // Alone in its region it would have these directions.
  const auto fine = RegionsOf(imaging, AnglesDeg(0, 45, 0, 90), 65, 65, kMaxPolar, 1024);
  for (const ImageRegion& region : fine) {
    if (region.pixels != std::vector<std::uint32_t>{pixel}) continue;
    EXPECT_NEAR(region.directions.wo.x(), -at / std::hypot(at, 0.5), 1e-12);
    EXPECT_NEAR(region.directions.wi.x(), light.normalized().x(), 1e-12);
  }
}

TEST(RegionsOf, DivideThePixelsAmongThem) {
  const ArmAngles arms = AnglesDeg(20, 40, 175, 50);
  const auto one = RegionsOf(Camera(), arms, 64, 64, kMaxPolar);
  const auto eight = RegionsOf(Camera(), arms, 64, 64, kMaxPolar, 8);
  EXPECT_EQ(eight.size(), 8u);
  EXPECT_EQ(PixelsOf(eight), PixelsOf(one));
  std::size_t sum = 0;
  for (const ImageRegion& region : eight) {
    sum += region.pixels.size();
    EXPECT_NEAR(region.pixels.size(), one[0].pixels.size() / 8.0, 3);
  }
  EXPECT_EQ(sum, one[0].pixels.size());
  // The first is the pose's own.
  const DirectionPair centre = RegionsOf({}, arms, 1, 1, kMaxPolar)[0].directions;
  const auto astray = [&](const ImageRegion& region) {
    return AngleBetween(region.directions.wi, centre.wi) +
           AngleBetween(region.directions.wo, centre.wo);
  };
  for (const ImageRegion& region : eight) EXPECT_LE(astray(eight[0]), astray(region));
}

// The point of image-based measurement: one image of a sphere holds a fan of theta_h at nearly the
// theta_d of the arms.
TEST(RegionsOf, OfASphereAreAFanOfHalfAngles) {
  Imaging imaging = Camera({.kind = SampleShape::Kind::kSphere, .radius = 0.02});
  imaging.patch_radius = 0.05;
  const auto regions = RegionsOf(imaging, AnglesDeg(0, 60, 180, 60), 128, 128, kMaxPolar, 64);
  ASSERT_EQ(regions.size(), 64u);
  double low = kPi;
  double high = 0;
  for (const ImageRegion& region : regions) {
    const HalfDiff angles = ToHalfDiff(region.directions);
    low = std::min(low, angles.theta_h);
    high = std::max(high, angles.theta_h);
    EXPECT_NEAR(angles.theta_d, RadFromDeg(30), RadFromDeg(2));
  }
  EXPECT_LT(low, RadFromDeg(10));
  EXPECT_GT(high, RadFromDeg(45));
}

// A cylinder along x curves in y only.
TEST(RegionsOf, OfACylinderFanOutAcrossItsAxis) {
  Imaging imaging = Camera({.kind = SampleShape::Kind::kCylinder, .radius = 0.02});
  imaging.patch_radius = 0.012;
  const auto regions = RegionsOf(imaging, AnglesDeg(0, 80, 0, 70), 64, 64, kMaxPolar, 64);
  double along = 0;
  double across = 0;
  for (const ImageRegion& region : regions) {
    along = std::max(along, std::abs(region.directions.wo.x() - std::cos(RadFromDeg(70))));
    across = std::max(across, std::abs(region.directions.wo.y()));
  }
  EXPECT_LT(along, 0.06);
  EXPECT_GT(across, 0.4);
}

TEST(RegionsOf, LeaveOutWhatIsDarkOrBelowTheLimit) {
  EXPECT_TRUE(RegionsOf(Camera(), AnglesDeg(0, 2, 180, 60), 64, 64, kMaxPolar).empty());
  EXPECT_TRUE(RegionsOf(Camera(), AnglesDeg(0, 60, 180, 2), 64, 64, kMaxPolar).empty());
  // The side of a sphere that is turned away from the light.
  Imaging imaging = Camera({.kind = SampleShape::Kind::kSphere, .radius = 0.02});
  imaging.patch_radius = 0;
  const auto lit = RegionsOf(imaging, AnglesDeg(0, 10, 0, 90), 128, 128, kMaxPolar);
  const auto all = RegionsOf(imaging, AnglesDeg(0, 90, 0, 90), 128, 128, kMaxPolar);
  EXPECT_LT(lit[0].pixels.size(), 0.7 * all[0].pixels.size());
}

}  // namespace
}  // namespace gonio
