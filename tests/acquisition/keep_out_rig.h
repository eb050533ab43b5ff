// SPDX-License-Identifier: Apache-2.0
// A rig whose arms can meet, and the gap between them found by points instead of geometry.

#pragma once

#include <algorithm>
#include <limits>

#include "tests/acquisition/simulated_rig.h"

namespace gonio {

inline constexpr double kArmFrom = 0.2;      // m along the arm
inline constexpr double kArmTo = 0.7;        // m
inline constexpr double kArmRadius = 0.03;   // m
inline constexpr double kTableTop = -0.025;  // m: z

// Two bars that point at the sample, over a table.
inline RigConfig RigOfTwoPosts() {
  RigConfig rig = DefaultRig();
  const SolidPart bar{.from = {kArmFrom, 0, 0}, .to = {kArmTo, 0, 0}, .radius = kArmRadius};
  rig.keep_out.margin = 0.01;
  rig.keep_out.light_arm = {bar};
  rig.keep_out.camera_arm = {bar};
  rig.keep_out.fixed = {
      {.shape = SolidPart::Shape::kBox, .from = {-1, -1, -0.2}, .to = {1, 1, kTableTop}}};
  return rig;
}

// m; negative: they are inside each other. Up to 2 mm too large.
inline double SampledGap(const ArmAngles& angles) {
  const Eigen::Vector3d light =
      FromSpherical(kPi / 2 - angles[kLightElevation], angles[kLightAzimuth]);
  const Eigen::Vector3d camera =
      FromSpherical(kPi / 2 - angles[kCameraElevation], angles[kCameraAzimuth]);
  double gap = std::numeric_limits<double>::infinity();
  for (const Eigen::Vector3d& arm : {light, camera}) {
    gap = std::min(gap, std::min(kArmFrom * arm.z(), kArmTo * arm.z()) - kTableTop - kArmRadius);
  }
  // Of two rays from one point, the nearest points of bars are at the same distance from it, or at
  // an end of one.
  constexpr int kPoints = 64;
  for (int i = 0; i <= kPoints; ++i) {
    const Eigen::Vector3d p = light * (kArmFrom + (kArmTo - kArmFrom) * i / kPoints);
    const double along = std::clamp(p.dot(camera), kArmFrom, kArmTo);
    gap = std::min(gap, (p - along * camera).norm() - 2 * kArmRadius);
  }
  return gap;
}

}  // namespace gonio
