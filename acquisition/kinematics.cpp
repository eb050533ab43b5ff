// SPDX-License-Identifier: Apache-2.0
#include "acquisition/kinematics.h"

#include <algorithm>
#include <cmath>

#include "acquisition/sample_orientation.h"
#include "core/units.h"
#include "drivers/move_time.h"

namespace gonio {
namespace {

// Where a sample that must not touch the arms is turned to where it would [rad].
constexpr double kTurnStep = kPi / 6;

double PolarAngle(const Eigen::Vector3d& direction) {
  return std::atan2(std::hypot(direction.x(), direction.y()), direction.z());
}

}  // namespace

Kinematics::Kinematics(const RigConfig& rig) : geometry_(rig.geometry) {
  std::transform(rig.axes.begin(), rig.axes.end(), soonest_.limits.begin(), TargetLimits);
  soonest_.kind = geometry_.kind;
  offsets_ = rig.axis_offsets;
  for (int i = 0; i < kAxes; ++i) {
    AxisLimits& limits = soonest_.limits[i];
    limits.min_position += offsets_[i];
    limits.max_position += offsets_[i];
    if (!rig.time_model) continue;
    limits.max_speed = rig.time_model->max_speed[i];
    limits.acceleration = rig.time_model->acceleration[i];
    limits.move_overhead = rig.time_model->move_overhead[i];
  }
  all_ = soonest_;
  if (rig.keep_out.sample.empty()) return;
  for (double turn = -2 * kPi; turn <= 2 * kPi; turn += kTurnStep) {
    all_.sample_turns.push_back(turn);
  }
}

AxisPositions Kinematics::TruePositions(AxisPositions encoders) const {
  for (int i = 0; i < kAxes; ++i) encoders[i] += offsets_[i];
  return encoders;
}

ArmAngles Kinematics::TrueAngles(const AxisPositions& encoders) const {
  return ArmsOf(geometry_.kind, TruePositions(encoders));
}

Imaging Kinematics::ImagingAt(Imaging imaging, const AxisPositions& encoders) const {
  if (geometry_.kind != RigKind::kTiltingSample) return imaging;
  // Without a calibration, which is refused for such rigs, there is no other turn.
  imaging.camera_turn[2] = CameraRoll(TruePositions(encoders));
  return imaging;
}

DirectionPair Kinematics::Forward(const AxisPositions& encoders) const {
  const ArmAngles angles = TrueAngles(encoders);
  return {FromSpherical(kPi / 2 - angles[kLightElevation], angles[kLightAzimuth]),
          FromSpherical(kPi / 2 - angles[kCameraElevation], angles[kCameraAzimuth])};
}

bool Kinematics::Allowed(const DirectionPair& pair) const {
  return pair.above_horizon() && PolarAngle(pair.wi) <= geometry_.max_polar + kLimitRounding &&
         PolarAngle(pair.wo) <= geometry_.max_polar + kLimitRounding &&
         AngleBetween(pair.wi, pair.wo) >= geometry_.min_separation - kLimitRounding;
}

template <typename Visit>
void Kinematics::VisitEncoders(const AxisSpace& space, const DirectionPair& pair,
                               const AxisPositions& from, const Visit& visit) const {
  if (!Allowed(pair)) return;
  VisitSolutions(space, pair, TruePositions(from), [&](AxisPositions positions) {
    for (int i = 0; i < kAxes; ++i) positions[i] -= offsets_[i];
    visit(positions);
  });
}

std::optional<AxisPositions> Kinematics::Inverse(const DirectionPair& pair,
                                                 const AxisPositions& from) const {
  std::optional<AxisPositions> best;
  Seconds best_time{0};
  VisitEncoders(soonest_, pair, from, [&](const AxisPositions& positions) {
    const Seconds time = TravelTime(from, positions);
    if (best && time >= best_time - Seconds(1e-9)) return;
    best = positions;
    best_time = time;
  });
  return best;
}

std::vector<AxisPositions> Kinematics::Solutions(const DirectionPair& pair,
                                                 const AxisPositions& from) const {
  std::vector<AxisPositions> solutions;
  if (const auto best = Inverse(pair, from)) solutions.push_back(*best);
  VisitEncoders(all_, pair, from, [&](const AxisPositions& positions) {
    if (std::find(solutions.begin(), solutions.end(), positions) == solutions.end()) {
      solutions.push_back(positions);
    }
  });
  if (solutions.empty()) return solutions;
  std::stable_sort(solutions.begin() + 1, solutions.end(), [&](const auto& a, const auto& b) {
    return TravelTime(from, a) < TravelTime(from, b);
  });
  return solutions;
}

bool Kinematics::Reachable(const DirectionPair& pair) const {
  return Inverse(pair, AxisPositions{}).has_value();
}

Seconds Kinematics::TravelTime(const AxisPositions& from, const AxisPositions& to) const {
  Seconds longest{0};
  for (int i = 0; i < kAxes; ++i) {
    longest = std::max(longest, MoveTime(to[i] - from[i], soonest_.limits[i]));
  }
  return longest;
}

}  // namespace gonio
