// SPDX-License-Identifier: Apache-2.0
#include "brdf/direction.h"

#include <Eigen/Geometry>
#include <cmath>

#include "core/units.h"

namespace gonio {

Eigen::Vector3d FromSpherical(double theta, double phi) {
  return {std::sin(theta) * std::cos(phi), std::sin(theta) * std::sin(phi), std::cos(theta)};
}

double AngleBetween(const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  return 2 * std::atan2((a - b).norm(), (a + b).norm());
}

DirectionPair ToDirections(const HalfDiff& angles) {
  const Eigen::Vector3d d = FromSpherical(angles.theta_d, angles.phi_d);
  const Eigen::AngleAxisd tilt(angles.theta_h, Eigen::Vector3d::UnitY());
  return {tilt * d, tilt * Eigen::Vector3d(-d.x(), -d.y(), d.z())};
}

HalfDiff ToHalfDiff(const DirectionPair& pair) {
  const Eigen::Vector3d sum = pair.wi + pair.wo;
  const Eigen::Vector3d difference = pair.wi - pair.wo;
  HalfDiff angles;
  const double sum_xy = std::hypot(sum.x(), sum.y());
  angles.theta_h = std::atan2(sum_xy, sum.z());
  angles.theta_d = std::atan2(difference.norm(), sum.norm());
  if (sum_xy <= 0 || difference.squaredNorm() <= 0) return angles;

  // d's x and y in the frame whose z is h: x points to where h tilts further, y = z cross h.
  const Eigen::Vector3d h = sum.normalized();
  const Eigen::Vector3d y_axis = Eigen::Vector3d(-sum.y(), sum.x(), 0) / sum_xy;
  const Eigen::Vector3d x_axis = y_axis.cross(h);
  angles.phi_d = std::atan2(difference.dot(y_axis), difference.dot(x_axis));
  if (angles.phi_d < 0) angles.phi_d += kPi;
  if (angles.phi_d >= kPi) angles.phi_d -= kPi;
  return angles;
}

}  // namespace gonio
