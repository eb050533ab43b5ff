// SPDX-License-Identifier: Apache-2.0
#include "acquisition/axis_solutions.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "core/units.h"
#include "drivers/move_time.h"

namespace gonio {
namespace {

// Closer to the normal than this [rad] an azimuth means nothing.
constexpr double kZenith = 1e-7;
// A pair that stands out of one plane with the normal by less [rad] is in it.
constexpr double kInPlane = 1e-6;

double PolarAngle(const Eigen::Vector3d& direction) {
  return std::atan2(std::hypot(direction.x(), direction.y()), direction.z());
}

double Azimuth(const Eigen::Vector3d& direction) {
  return std::atan2(direction.y(), direction.x());
}

double Clamped(double position, const AxisLimits& limits) {
  return std::clamp(position, limits.min_position, limits.max_position);
}

// `position` put inside the limits if only rounding took it out, else nullopt.
std::optional<double> WithinLimits(double position, const AxisLimits& limits) {
  if (position < limits.min_position - kLimitRounding ||
      position > limits.max_position + kLimitRounding) {
    return std::nullopt;
  }
  return Clamped(position, limits);
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
                   const AxisPositions& from, Visit&& visit) {
  double low = std::max(light.min_position, camera.min_position - difference);
  double high = std::min(light.max_position, camera.max_position - difference);
  if (low > high + kLimitRounding) return;
  if (low > high) low = high = (low + high) / 2;
  const double light_still = from[kLightAzimuth];
  const double camera_still = from[kCameraAzimuth] - difference;
  // Fewer moving axes first: a later candidate must be faster to win.
  for (const double wanted :
       {light_still, camera_still, Balance(light_still, light, camera_still, camera)}) {
    const double azimuth = std::clamp(wanted, low, high);
    visit(Clamped(azimuth, light), Clamped(azimuth + difference, camera));
  }
}

void VisitFourAxisArms(const AxisSpace& space, const DirectionPair& pair, const AxisPositions& from,
                       const VisitAxes& visit) {
  const double theta_i = PolarAngle(pair.wi);
  const double theta_o = PolarAngle(pair.wo);
  const auto light = WithinLimits(kPi / 2 - theta_i, space.limits[kLightElevation]);
  const auto camera = WithinLimits(kPi / 2 - theta_o, space.limits[kCameraElevation]);
  if (!light || !camera) return;

  const auto at_azimuths = [&](double light_azimuth, double camera_azimuth) {
    visit({light_azimuth, *light, camera_azimuth, *camera});
  };
  const AxisLimits& light_limits = space.limits[kLightAzimuth];
  const AxisLimits& camera_limits = space.limits[kCameraAzimuth];
  if (std::min(theta_i, theta_o) < kZenith) {
    at_azimuths(Clamped(from[kLightAzimuth], light_limits),
                Clamped(from[kCameraAzimuth], camera_limits));
    return;
  }
  const double difference = Azimuth(pair.wo) - Azimuth(pair.wi);
  for (const double mirrored : {difference, -difference}) {
    for (int turns = -3; turns <= 3; ++turns) {  // azimuths may span -360 .. 360 deg
      VisitAzimuths(mirrored + 2 * kPi * turns, light_limits, camera_limits, from, at_azimuths);
    }
  }
}

// Where it stands, then the others that the limits allow.
template <typename Visit>
void VisitTurns(const AxisSpace& space, int axis, const AxisPositions& from, const Visit& visit) {
  const AxisLimits& limits = space.limits[axis];
  visit(Clamped(from[axis], limits));
  for (const double turn : space.sample_turns) {
    if (turn > limits.min_position && turn < limits.max_position) visit(turn);
  }
}

// The light on one side of the normal or, mirrored, on the other.
void VisitTurntable(const AxisSpace& space, const DirectionPair& pair, const AxisPositions& from,
                    const VisitAxes& visit) {
  const Eigen::Vector2d light = pair.wi.head<2>();
  const Eigen::Vector2d camera = pair.wo.head<2>();
  if (std::abs(light.x() * camera.y() - light.y() * camera.x()) > kInPlane) return;
  const double opposite = light.dot(camera) < 0 ? -1 : 1;
  const double theta_i = PolarAngle(pair.wi);
  const double theta_o = opposite * PolarAngle(pair.wo);
  for (const double side : {1, -1}) {
    const auto light_arm =
        WithinLimits(kPi / 2 - side * theta_i, space.limits[turntable::kLightArm]);
    const auto camera_arm =
        WithinLimits(kPi / 2 - side * theta_o, space.limits[turntable::kCameraArm]);
    if (!light_arm || !camera_arm) continue;
    VisitTurns(space, turntable::kSampleTurn, from, [&](double turn) {
      visit({*light_arm, *camera_arm, turn});
    });
  }
}

// The sample's normal in the laboratory whose light, along x, and camera, `arm` from it about z,
// show the pair; turned upside down, z, it shows the mirrored pair. Where the two are in one place
// any normal at that angle from it will do.
Eigen::Vector3d NormalInLab(const DirectionPair& pair, double arm) {
  const double along = pair.wi.z();
  const double sine = std::sin(arm);
  if (std::abs(sine) < kZenith) return {along, std::sqrt(std::max(0.0, 1 - along * along)), 0};
  const double across = (pair.wo.z() - std::cos(arm) * along) / sine;
  // Light, camera and normal span the same volume in the sample's frame.
  const double up = (pair.wi.x() * pair.wo.y() - pair.wi.y() * pair.wo.x()) / sine;
  return {along, across, std::abs(up)};
}

// Hands `angle` and what differs by full turns to visit, inside the limits.
template <typename Visit>
void VisitWindings(double angle, const AxisLimits& limits, const Visit& visit) {
  for (int turns = -1; turns <= 1; ++turns) {
    if (const auto within = WithinLimits(angle + 2 * kPi * turns, limits)) visit(*within);
  }
}

// The camera on either side of the light; the normal tips up or down.
void VisitTiltingSample(const AxisSpace& space, const DirectionPair& pair,
                        const AxisPositions& from, const VisitAxes& visit) {
  using namespace tilting_sample;
  const double between = AngleBetween(pair.wi, pair.wo);
  for (const double side : {1, -1}) {
    const Eigen::Vector3d normal = NormalInLab(pair, side * between);
    const double turn = std::atan2(normal.y(), normal.x());
    const double tilt = std::atan2(normal.z(), std::hypot(normal.x(), normal.y()));
    for (const double up : {1, -1}) {
      const auto tilted = WithinLimits(up * tilt, space.limits[kSampleTilt]);
      if (!tilted) continue;
      VisitWindings(side * between, space.limits[kCameraArm], [&](double arm) {
        VisitWindings(turn, space.limits[kSampleTurn], [&](double turned) {
          VisitTurns(space, kSampleAzimuth, from, [&](double azimuth) {
            visit({arm, turned, *tilted, azimuth});
          });
        });
      });
    }
  }
}

}  // namespace

void VisitSolutions(const AxisSpace& space, const DirectionPair& pair, const AxisPositions& from,
                    const VisitAxes& visit) {
  switch (space.kind) {
    case RigKind::kFourAxisArms:
      return VisitFourAxisArms(space, pair, from, visit);
    case RigKind::kTurntable:
      return VisitTurntable(space, pair, from, visit);
    case RigKind::kTiltingSample:
      return VisitTiltingSample(space, pair, from, visit);
  }
}

}  // namespace gonio
