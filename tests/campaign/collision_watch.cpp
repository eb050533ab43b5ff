// SPDX-License-Identifier: Apache-2.0
#include "tests/campaign/collision_watch.h"

#include <cmath>

#include "core/check.h"

namespace gonio {
namespace {

constexpr double kStep = 0.01;  // m

double GapToBox(const Eigen::Vector3d& point, const SolidPart& box) {
  const Eigen::Vector3d nearest = point.cwiseMax(box.from).cwiseMin(box.to);
  return (point - nearest).norm();
}

}  // namespace

CollisionWatch::CollisionWatch(const RigConfig& rig) : config_(rig.keep_out) {
  for (const auto* arm : {&config_.light_arm, &config_.camera_arm}) {
    for (const SolidPart& part : *arm) {
      GONIO_CHECK(part.shape == SolidPart::Shape::kCapsule, "an arm of capsules");
    }
  }
  for (const SolidPart& part : config_.fixed) {
    GONIO_CHECK(part.shape == SolidPart::Shape::kBox, "boxes that stand still");
  }
}

std::vector<CollisionWatch::Ball> CollisionWatch::BallsOf(const std::vector<SolidPart>& parts,
                                                          double azimuth, double elevation) {
  std::vector<Ball> balls;
  for (const SolidPart& part : parts) {
    const double tilt = part.axes > 1 ? elevation : 0;
    const Eigen::Vector3d along(std::cos(tilt) * std::cos(azimuth),
                                std::cos(tilt) * std::sin(azimuth), std::sin(tilt));
    const Eigen::Vector3d up(-std::sin(tilt) * std::cos(azimuth),
                             -std::sin(tilt) * std::sin(azimuth), std::cos(tilt));
    const Eigen::Vector3d across = up.cross(along);
    const int steps = 1 + static_cast<int>((part.to - part.from).norm() / kStep);
    for (int i = 0; i <= steps; ++i) {
      const Eigen::Vector3d p = part.from + (part.to - part.from) * i / steps;
      balls.push_back({p.x() * along + p.y() * across + p.z() * up, part.radius});
    }
  }
  return balls;
}

std::optional<std::string> CollisionWatch::FindAt(const ArmAngles& angles, double gap) const {
  const auto light = BallsOf(config_.light_arm, angles[kLightAzimuth], angles[kLightElevation]);
  const auto camera = BallsOf(config_.camera_arm, angles[kCameraAzimuth], angles[kCameraElevation]);
  for (const Ball& a : light) {
    for (const Ball& b : camera) {
      if ((a.at - b.at).norm() - a.radius - b.radius < gap) return "light arm and camera arm";
    }
  }
  for (const SolidPart& box : config_.fixed) {
    for (const Ball& a : light) {
      if (GapToBox(a.at, box) - a.radius < gap) return "light arm and what stands still";
    }
    for (const Ball& b : camera) {
      if (GapToBox(b.at, box) - b.radius < gap) return "camera arm and what stands still";
    }
  }
  return std::nullopt;
}

}  // namespace gonio
