// SPDX-License-Identifier: Apache-2.0
// The directional-statistics BRDF, continuous in theta_d.

#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "fitting/lobe_model.h"

namespace gonio {

// How many parameters a DSBRDF has and where each stands in the vector.
struct DsbrdfShape {
  int lobes = 3;  // 1 .. 5
  int knots = 7;  // spline coefficients over theta_d per lobe, channel and quantity, 4 .. 20

  bool operator==(const DsbrdfShape&) const = default;
  int size() const { return kChannels * per_channel(); }
  int per_channel() const { return lobes * 2 * knots; }
  // Index of the first coefficient of log kappa (quantity 0) or log gamma (quantity 1).
  int Index(int channel, int lobe, int quantity) const {
    return ((channel * lobes + lobe) * 2 + quantity) * knots;
  }
};

inline constexpr int kMaxLobes = 5;
inline constexpr int kMinKnots = 4;
inline constexpr int kMaxKnots = 20;

// Throws ConfigError "lobes: is 7, must be 1 to 5".
void CheckShape(const DsbrdfShape& shape);

// f_r of K Hemi-EPD lobes per channel (Nishino, "Directional Statistics BRDF Model", ICCV 2009;
// Nishino & Lombardi, JOSA A 28(1), 2011), with the slices in theta_d replaced by splines:
//
//   f(theta_h, theta_d) = sum_k exp(kappa_k(theta_d) cos^gamma_k(theta_d) theta_h) - 1
//
// log kappa_k and log gamma_k are cubic B-splines of theta_d (fitting/spline.h). Lobes are ordered
// from the broadest (small gamma: the diffuse part) to the narrowest. f does not depend on phi_d.
class Dsbrdf final : public LobeModel {
 public:
  // Throws ConfigError if the shape is out of range. Precondition: parameters.size() ==
  // shape.size().
  Dsbrdf(DsbrdfShape shape, Eigen::VectorXd parameters, std::string name = "DSBRDF");

  using Brdf::Eval;
  // Never empty above the horizon.
  std::optional<Rgb> Eval(const HalfDiff& angles) const override;
  std::string name() const override { return name_; }
  int lobes() const override { return shape_.lobes; }
  std::vector<Lobe> LobesAt(double theta_d, int channel) const override;

  const DsbrdfShape& shape() const { return shape_; }
  const Eigen::VectorXd& parameters() const { return parameters_; }

 private:
  DsbrdfShape shape_;
  Eigen::VectorXd parameters_;
  std::string name_;
};

}  // namespace gonio
