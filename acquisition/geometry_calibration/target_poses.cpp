// SPDX-License-Identifier: Apache-2.0
#include "acquisition/geometry_calibration/target_poses.h"

#include <cmath>

#include "acquisition/geometry_calibration/bundle.h"
#include "brdf/direction.h"
#include "core/units.h"
#include "drivers/move_time.h"

namespace gonio {
namespace {

bool Allowed(const RigConfig& rig, const ArmAngles& arms) {
  for (int i = 0; i < kAxes; ++i) {
    const AxisLimits limits = TargetLimits(rig.axes[i]);
    if (arms[i] < limits.min_position || arms[i] > limits.max_position) return false;
  }
  const auto direction = [&](int azimuth, int elevation) {
    return FromSpherical(kPi / 2 - arms[elevation], arms[azimuth]);
  };
  const double lowest = kPi / 2 - rig.geometry.max_polar;
  return arms[kLightElevation] >= lowest && arms[kCameraElevation] >= lowest &&
         AngleBetween(direction(kLightAzimuth, kLightElevation),
                      direction(kCameraAzimuth, kCameraElevation)) >= rig.geometry.min_separation;
}

// -180 .. 180 deg.
double Wrapped(double degrees) { return std::remainder(degrees, 360); }

void AddIfAllowed(const RigConfig& rig, const std::array<double, kAxes>& degrees,
                  std::vector<ArmAngles>& poses) {
  ArmAngles arms{};
  for (int i = 0; i < kAxes; ++i) arms[i] = RadFromDeg(degrees[i]);
  if (Allowed(rig, arms)) poses.push_back(arms);
}

// Away from the border by this part of the image [px].
constexpr double kMargin = 0.08;

bool InImage(const RigConfig& rig, const ArmAngles& arms) {
  const int width = rig.camera.width;
  const int height = rig.camera.height;
  const Eigen::Vector2d at = PredictHighlight({rig.imaging, width, height}, arms);
  return at.x() > kMargin * width && at.x() < (1 - kMargin) * width && at.y() > kMargin * height &&
         at.y() < (1 - kMargin) * height;
}

}  // namespace

std::vector<ArmAngles> BoardPoses(const RigConfig& rig) {
  std::vector<ArmAngles> poses;
  bool up = true;
  for (double azimuth = -150; azimuth <= 180; azimuth += 60) {
    for (int i = 0; i < 4; ++i) {
      const double elevation = up ? 40 + 14 * i : 82 - 14 * i;
      AddIfAllowed(rig, {Wrapped(azimuth + 90), 60, azimuth, elevation}, poses);
    }
    up = !up;
  }
  return poses;
}

std::vector<ArmAngles> MirrorPoses(const RigConfig& rig) {
  std::vector<ArmAngles> poses;
  for (const double azimuth : {-120.0, -40.0, 40.0, 120.0}) {
    for (const double elevation : {50.0, 65.0}) {
      for (const auto& [side, over] :
           {std::pair{0.0, 0.0}, {8.0, 4.0}, {-8.0, 4.0}, {8.0, -4.0}, {-8.0, -4.0}}) {
        const std::size_t before = poses.size();
        AddIfAllowed(rig, {azimuth, elevation, Wrapped(azimuth + 180 + side), elevation + over},
                     poses);
        if (poses.size() > before && !InImage(rig, poses.back())) poses.pop_back();
      }
    }
  }
  return poses;
}

}  // namespace gonio
