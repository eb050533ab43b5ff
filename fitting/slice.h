// SPDX-License-Identifier: Apache-2.0
// A DSBRDF at one theta_d: its lobes as plain numbers, and their derivatives.

#pragma once

#include <Eigen/Core>
#include <array>

#include "fitting/dsbrdf.h"
#include "fitting/hemi_epd.h"
#include "fitting/spline.h"

namespace gonio {

// kappa and gamma of every lobe and channel where theta_d is fixed.
//
// Derivatives are with respect to log kappa and log gamma of the slice, in the order lobe 0's
// kappa, lobe 0's gamma, lobe 1's kappa, ...; the chain rule to spline coefficient j of that
// quantity multiplies by basis().weight[j].
class Slice {
 public:
  Slice(const DsbrdfShape& shape, const Eigen::VectorXd& parameters, double theta_d);

  // f_r of one channel; log_cos = LogCos(theta_h).
  double Eval(int channel, double log_cos) const;
  // The same; fills gradient[0 .. 2 * lobes).
  double EvalWithGradient(int channel, double log_cos, double* gradient) const;

  const SplineBasis& basis() const { return basis_; }
  const Lobe& lobe(int channel, int k) const { return lobes_[channel][k].lobe(); }
  double kappa(int channel, int k) const { return lobe(channel, k).kappa; }
  double gamma(int channel, int k) const { return lobe(channel, k).gamma; }

 private:
  int lobe_count_;
  SplineBasis basis_;
  std::array<std::array<BoundedLobe, kMaxLobes>, kChannels> lobes_;
};

}  // namespace gonio
