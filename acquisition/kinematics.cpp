// SPDX-License-Identifier: Apache-2.0
#include "acquisition/kinematics.h"

#include <algorithm>
#include <cmath>

#include "core/units.h"
#include "drivers/move_time.h"

namespace gonio {
namespace {

// Limits are kept to this much rounding [rad]; far below any encoder's step.
constexpr double kRounding = 1e-9;
// Closer to the normal than this [rad] an azimuth means nothing.
constexpr double kZenith = 1e-7;

double PolarAngle(const Eigen::Vector3d& direction) {
  return std::atan2(std::hypot(direction.x(), direction.y()), direction.z());
}

double Azimuth(const Eigen::Vector3d& direction) {
  return std::atan2(direction.y(), direction.x());
}

// `position` put inside the limits if only rounding took it out, else nullopt.
std::optional<double> WithinLimits(double position, const AxisLimits& limits) {
  if (position < limits.min_position - kRounding || position > limits.max_position + kRounding) {
    return std::nullopt;
  }
  return std::clamp(position, limits.min_position, limits.max_position);
}

// Where between `a_home` and `b_home` two axes that must stay a fixed angle apart arrive at the
// same time: each wants to stay at its own home, and moving towards the other's is the compromise.
double Balance(double a_home, const AxisLimits& a, double b_home, const AxisLimits& b) {
  double near = 0;  // as a fraction of the way from a_home to b_home
  double far = 1;
  for (int i = 0; i < 50; ++i) {
    const double middle = (near + far) / 2;
    const double way = b_home - a_home;
    const bool sooner =
        TimeOfMove(std::abs(middle * way), a) < TimeOfMove(std::abs((1 - middle) * way), b);
    (sooner ? near : far) = middle;
  }
  return a_home + near * (b_home - a_home);
}

// The azimuths that keep camera - light = `difference` inside the limits: the light's come from
// an interval, and the best of it is one of three, as travel time is unimodal along it.
template <typename Visit>
void VisitAzimuths(double difference, const AxisLimits& light, const AxisLimits& camera,
                   const ArmAngles& from, Visit&& visit) {
  double low = std::max(light.min_position, camera.min_position - difference);
  double high = std::min(light.max_position, camera.max_position - difference);
  if (low > high + kRounding) return;
  if (low > high) low = high = (low + high) / 2;
  const double light_still = from[kLightAzimuth];
  const double camera_still = from[kCameraAzimuth] - difference;
  // Fewer moving axes first: a later candidate must be faster to win.
  for (const double wanted :
       {light_still, camera_still, Balance(light_still, light, camera_still, camera)}) {
    const double azimuth = std::clamp(wanted, low, high);
    visit(std::clamp(azimuth, light.min_position, light.max_position),
          std::clamp(azimuth + difference, camera.min_position, camera.max_position));
  }
}

}  // namespace

Kinematics::Kinematics(const RigConfig& rig) : geometry_(rig.geometry) {
  std::transform(rig.axes.begin(), rig.axes.end(), limits_.begin(), TargetLimits);
  offsets_ = rig.axis_offsets;
  for (int i = 0; i < kAxes; ++i) {
    AxisLimits& limits = limits_[i];
    limits.min_position += offsets_[i];
    limits.max_position += offsets_[i];
    if (!rig.time_model) continue;
    limits.max_speed = rig.time_model->max_speed[i];
    limits.acceleration = rig.time_model->acceleration[i];
    limits.move_overhead = rig.time_model->move_overhead[i];
  }
}

ArmAngles Kinematics::TrueAngles(ArmAngles encoders) const {
  for (int i = 0; i < kAxes; ++i) encoders[i] += offsets_[i];
  return encoders;
}

DirectionPair Kinematics::Forward(const ArmAngles& encoders) const {
  const ArmAngles angles = TrueAngles(encoders);
  return {FromSpherical(kPi / 2 - angles[kLightElevation], angles[kLightAzimuth]),
          FromSpherical(kPi / 2 - angles[kCameraElevation], angles[kCameraAzimuth])};
}

bool Kinematics::Allowed(const DirectionPair& pair) const {
  return pair.above_horizon() && PolarAngle(pair.wi) <= geometry_.max_polar + kRounding &&
         PolarAngle(pair.wo) <= geometry_.max_polar + kRounding &&
         AngleBetween(pair.wi, pair.wo) >= geometry_.min_separation - kRounding;
}

template <typename Visit>
void Kinematics::VisitSolutions(const DirectionPair& pair, const ArmAngles& from_encoders,
                                const Visit& visit) const {
  if (!Allowed(pair)) return;
  const ArmAngles from = TrueAngles(from_encoders);  // as the limits are
  const double theta_i = PolarAngle(pair.wi);
  const double theta_o = PolarAngle(pair.wo);
  const auto light = WithinLimits(kPi / 2 - theta_i, limits_[kLightElevation]);
  const auto camera = WithinLimits(kPi / 2 - theta_o, limits_[kCameraElevation]);
  if (!light || !camera) return;

  const auto at_azimuths = [&](double light_azimuth, double camera_azimuth) {
    ArmAngles angles = {light_azimuth, *light, camera_azimuth, *camera};
    for (int i = 0; i < kAxes; ++i) angles[i] -= offsets_[i];
    visit(angles);
  };
  const AxisLimits& light_limits = limits_[kLightAzimuth];
  const AxisLimits& camera_limits = limits_[kCameraAzimuth];
  if (std::min(theta_i, theta_o) < kZenith) {
    at_azimuths(
        std::clamp(from[kLightAzimuth], light_limits.min_position, light_limits.max_position),
        std::clamp(from[kCameraAzimuth], camera_limits.min_position, camera_limits.max_position));
    return;
  }
  const double difference = Azimuth(pair.wo) - Azimuth(pair.wi);
  for (const double mirrored : {difference, -difference}) {
    for (int turns = -3; turns <= 3; ++turns) {  // azimuths may span -360 .. 360 deg
      VisitAzimuths(mirrored + 2 * kPi * turns, light_limits, camera_limits, from, at_azimuths);
    }
  }
}

std::optional<ArmAngles> Kinematics::Inverse(const DirectionPair& pair,
                                             const ArmAngles& from) const {
  std::optional<ArmAngles> best;
  Seconds best_time{0};
  VisitSolutions(pair, from, [&](const ArmAngles& angles) {
    const Seconds time = TravelTime(from, angles);
    if (best && time >= best_time - Seconds(1e-9)) return;
    best = angles;
    best_time = time;
  });
  return best;
}

std::vector<ArmAngles> Kinematics::Solutions(const DirectionPair& pair,
                                             const ArmAngles& from) const {
  std::vector<ArmAngles> solutions;
  if (const auto best = Inverse(pair, from)) solutions.push_back(*best);
  VisitSolutions(pair, from, [&](const ArmAngles& angles) {
    if (std::find(solutions.begin(), solutions.end(), angles) == solutions.end()) {
      solutions.push_back(angles);
    }
  });
  if (solutions.empty()) return solutions;
  std::stable_sort(solutions.begin() + 1, solutions.end(), [&](const auto& a, const auto& b) {
    return TravelTime(from, a) < TravelTime(from, b);
  });
  return solutions;
}

bool Kinematics::Reachable(const DirectionPair& pair) const {
  return Inverse(pair, ArmAngles{}).has_value();
}

Seconds Kinematics::TravelTime(const ArmAngles& from, const ArmAngles& to) const {
  Seconds longest{0};
  for (int i = 0; i < kAxes; ++i) {
    longest = std::max(longest, MoveTime(to[i] - from[i], limits_[i]));
  }
  return longest;
}

}  // namespace gonio
