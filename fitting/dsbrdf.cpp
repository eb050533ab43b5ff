// SPDX-License-Identifier: Apache-2.0
#include "fitting/dsbrdf.h"

#include <fmt/format.h>

#include "core/error.h"
#include "fitting/slice.h"

namespace gonio {

void CheckShape(const DsbrdfShape& shape) {
  if (shape.lobes < 1 || shape.lobes > kMaxLobes) {
    throw ConfigError(fmt::format("lobes: is {}, must be 1 to {}", shape.lobes, kMaxLobes));
  }
  if (shape.knots < kMinKnots || shape.knots > kMaxKnots) {
    throw ConfigError(
        fmt::format("knots: is {}, must be {} to {}", shape.knots, kMinKnots, kMaxKnots));
  }
}

Dsbrdf::Dsbrdf(DsbrdfShape shape, Eigen::VectorXd parameters, std::string name)
    : shape_(shape), parameters_(std::move(parameters)), name_(std::move(name)) {
  CheckShape(shape_);
  GONIO_CHECK(parameters_.size() == shape_.size(), "one coefficient per spline knot");
}

std::optional<Rgb> Dsbrdf::Eval(const HalfDiff& angles) const {
  double cos_i = 0;
  double cos_o = 0;
  Cosines(angles, &cos_i, &cos_o);
  if (!(cos_i > 0 && cos_o > 0)) return std::nullopt;
  const Slice slice(shape_, parameters_, angles.theta_d);
  const double log_cos = LogCos(angles.theta_h);
  Rgb f_r;
  for (int c = 0; c < kChannels; ++c) f_r[c] = slice.Eval(c, log_cos);
  return f_r;
}

std::vector<Lobe> Dsbrdf::LobesAt(double theta_d, int channel) const {
  const Slice slice(shape_, parameters_, theta_d);
  std::vector<Lobe> lobes;
  for (int k = 0; k < shape_.lobes; ++k) lobes.push_back(slice.lobe(channel, k));
  return lobes;
}

}  // namespace gonio
