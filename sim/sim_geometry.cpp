// SPDX-License-Identifier: Apache-2.0
#include "sim/sim_geometry.h"

#include <cmath>

#include "core/units.h"

namespace gonio {
namespace {

using Eigen::Vector3d;

constexpr const char* kFourAxisNames[] = {"light_azimuth", "light_elevation", "camera_azimuth",
                                          "camera_elevation"};
constexpr const char* kTurntableNames[] = {"light_arm", "camera_arm", "sample_turn"};
constexpr const char* kTiltingSampleNames[] = {"camera_arm", "sample_turn", "sample_tilt",
                                               "sample_azimuth"};

// Of an arm in the frame that it turns in.
SimMount Arm(double azimuth, double elevation) {
  return {FromSpherical(kPi / 2 - elevation, azimuth),
          {-std::sin(azimuth), std::cos(azimuth), 0},
          {std::sin(elevation) * std::cos(azimuth), std::sin(elevation) * std::sin(azimuth),
           -std::cos(elevation)}};
}

// The sample's axes in the machine's frame.
struct SampleAxes {
  Vector3d x = Vector3d::UnitX();
  Vector3d y = Vector3d::UnitY();
  Vector3d normal = Vector3d::UnitZ();

  Vector3d Of(const Vector3d& v) const { return {x.dot(v), y.dot(v), normal.dot(v)}; }
  Eigen::Matrix3d FromMachine() const {
    Eigen::Matrix3d rows;
    rows << x.transpose(), y.transpose(), normal.transpose();
    return rows;
  }
  SimMount Of(const SimMount& mount) const {
    return {Of(mount.outward), Of(mount.right), Of(mount.down)};
  }
};

// A turntable: its normal stays up.
SampleAxes Turned(double angle) {
  SampleAxes sample;
  sample.x = Vector3d(std::cos(angle), std::sin(angle), 0);
  sample.y = Vector3d(-std::sin(angle), std::cos(angle), 0);
  return sample;
}

// A sample that hangs on a wall, so to say, its x level; then the wall is turned, tipped back, and
// the sample turned on it.
SampleAxes Hung(double turn, double tilt, double azimuth) {
  SampleAxes sample;
  sample.normal = {std::cos(tilt) * std::cos(turn), std::cos(tilt) * std::sin(turn),
                   std::sin(tilt)};
  const Vector3d level(-std::sin(turn), std::cos(turn), 0);
  const Vector3d upward = sample.normal.cross(level);
  sample.x = std::cos(azimuth) * level + std::sin(azimuth) * upward;
  sample.y = std::cos(azimuth) * upward - std::sin(azimuth) * level;
  return sample;
}

}  // namespace

SimRigKind ReadSimRigKind(const ConfigNode& root) {
  if (!root.Has("geometry") || !root.Map("geometry").Has("kind")) return SimRigKind::kFourAxisArms;
  const std::string kind = root.Map("geometry").Text("kind");
  if (kind == "turntable") return SimRigKind::kTurntable;
  return kind == "tilting-sample" ? SimRigKind::kTiltingSample : SimRigKind::kFourAxisArms;
}

std::span<const char* const> SimAxisNames(SimRigKind kind) {
  if (kind == SimRigKind::kTurntable) return kTurntableNames;
  if (kind == SimRigKind::kTiltingSample) return kTiltingSampleNames;
  return kFourAxisNames;
}

SimPlacement Place(SimRigKind kind, const SimArms& axes) {
  switch (kind) {
    case SimRigKind::kFourAxisArms:
      return {.light = Arm(axes[0], axes[1]), .camera = Arm(axes[2], axes[3])};
    case SimRigKind::kTurntable: {
      const SampleAxes sample = Turned(axes[2]);
      return {sample.Of(Arm(0, axes[0])), sample.Of(Arm(0, axes[1])), sample.FromMachine()};
    }
    case SimRigKind::kTiltingSample: {
      const SampleAxes sample = Hung(axes[1], axes[2], axes[3]);
      return {sample.Of(Arm(0, 0)), sample.Of(Arm(axes[0], 0)), sample.FromMachine()};
    }
  }
  return {};
}

}  // namespace gonio
