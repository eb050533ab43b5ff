// SPDX-License-Identifier: Apache-2.0
// Pairs of directions and their half/difference angles.

#pragma once

#include <Eigen/Core>
#include <cmath>

namespace gonio {

// A light and a detector direction in the sample frame: unit vectors, both pointing away from the
// surface; z is the sample's normal, x its reference direction (docs/geometry.md has a drawing).
struct DirectionPair {
  Eigen::Vector3d wi = Eigen::Vector3d::UnitZ();  // towards the light
  Eigen::Vector3d wo = Eigen::Vector3d::UnitZ();  // towards the detector

  // Cosines of the polar angles; a pair is physical only if both are > 0.
  double cos_theta_i() const { return wi.z(); }
  double cos_theta_o() const { return wo.z(); }
  bool above_horizon() const { return wi.z() > 0 && wo.z() > 0; }
};

// Half/difference angles [rad] (Rusinkiewicz, "A New Change of Variables for Efficient BRDF
// Representation", 1998): h = normalize(wi + wo), d = R_y(-theta_h) R_z(-phi_h) wi.
//
// phi_h is left out: an isotropic sample does not depend on it. phi_d is folded to [0, pi):
// reciprocity, f(wi, wo) = f(wo, wi), makes phi_d and phi_d + pi the same.
struct HalfDiff {
  double theta_h = 0;  // 0 .. pi/2, between the half vector and the normal
  double theta_d = 0;  // 0 .. pi/2, between the half vector and wi
  double phi_d = 0;    // 0 .. pi; means nothing where theta_d = 0 or theta_h = 0
};

// The unit vector at polar angle theta from z and azimuth phi from x [rad].
Eigen::Vector3d FromSpherical(double theta, double phi);

// The angle between two unit vectors [rad], accurate near 0 and pi where acos(dot) is not
// (W. Kahan, "How Futile are Mindless Assessments of Roundoff", 2006).
double AngleBetween(const Eigen::Vector3d& a, const Eigen::Vector3d& b);

// The pair with these angles and phi_h = 0. May lie below the horizon: ask above_horizon().
DirectionPair ToDirections(const HalfDiff& angles);

// The half/difference angles of a pair of unit vectors. Accurate to rounding everywhere, theta_h =
// 0 and theta_d = 0 included, where phi_d is reported as 0. Precondition: wi != -wo.
HalfDiff ToHalfDiff(const DirectionPair& pair);

// cos theta_i and cos theta_o without building the vectors:
// cos theta_d cos theta_h -+ sin theta_d cos phi_d sin theta_h.
inline void Cosines(const HalfDiff& angles, double* cos_theta_i, double* cos_theta_o) {
  const double a = std::cos(angles.theta_d) * std::cos(angles.theta_h);
  const double b = std::sin(angles.theta_d) * std::cos(angles.phi_d) * std::sin(angles.theta_h);
  *cos_theta_i = a - b;
  *cos_theta_o = a + b;
}

}  // namespace gonio
