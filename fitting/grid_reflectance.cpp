// SPDX-License-Identifier: Apache-2.0
#include "fitting/grid_reflectance.h"

#include <utility>

#include "core/check.h"

namespace gonio {
namespace {

constexpr double kFloor = 1e-3;  // 1/sr

}  // namespace

GridReflectance::GridReflectance(std::string name, AngleGrid grid, const Eigen::Matrix3Xf& f_r)
    : name_(std::move(name)), grid_(grid) {
  GONIO_CHECK(f_r.cols() == grid.size(), "a number for each node");
  log_f_r_ = (f_r.array() + static_cast<float>(kFloor)).log();
}

std::optional<Rgb> GridReflectance::Eval(const HalfDiff& angles) const {
  double cos_i = 0;
  double cos_o = 0;
  Cosines(angles, &cos_i, &cos_o);
  if (!(cos_i > 0 && cos_o > 0)) return std::nullopt;
  Rgb sum = Rgb::Zero();
  for (const AngleGrid::Corner& corner : grid_.Locate(angles)) {
    sum += corner.weight * log_f_r_.col(corner.index).array().cast<double>();
  }
  return Rgb((sum.exp() - kFloor).max(0));
}

}  // namespace gonio
