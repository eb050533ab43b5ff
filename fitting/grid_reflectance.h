// SPDX-License-Identifier: Apache-2.0
// A reflectance given by numbers at the nodes of a grid.

#pragma once

#include <Eigen/Core>
#include <string>

#include "brdf/brdf.h"
#include "fitting/angle_grid.h"

namespace gonio {

// ln(f_r + 1e-3 / sr) is linear between the nodes and constant beyond the outermost: peaks are
// nearer to straight in the logarithm, and on MERL tables that halves the error of interpolating
// f_r itself. Has a value wherever both directions are above the horizon. Evaluating takes about
// 0.1 us.
class GridReflectance final : public Brdf {
 public:
  // f_r [1/sr] >= 0: row c is channel c, column i node i.
  GridReflectance(std::string name, AngleGrid grid, const Eigen::Matrix3Xf& f_r);

  using Brdf::Eval;
  std::optional<Rgb> Eval(const HalfDiff& angles) const override;
  std::string name() const override { return name_; }

 private:
  std::string name_;
  AngleGrid grid_;
  Eigen::Matrix3Xf log_f_r_;
};

}  // namespace gonio
