// SPDX-License-Identifier: Apache-2.0
#include "fitting/slice.h"

namespace gonio {

Slice::Slice(const DsbrdfShape& shape, const Eigen::VectorXd& parameters, double theta_d)
    : lobe_count_(shape.lobes), basis_(BasisAt(theta_d, shape.knots)) {
  const auto spline = [&](int index) {
    const double* coefficient = parameters.data() + index + basis_.first;
    double sum = 0;
    for (int j = 0; j < 4; ++j) sum += basis_.weight[j] * coefficient[j];
    return sum;
  };
  for (int c = 0; c < kChannels; ++c) {
    for (int k = 0; k < shape.lobes; ++k) {
      lobes_[c][k] = BoundedLobe(spline(shape.Index(c, k, 0)), spline(shape.Index(c, k, 1)));
    }
  }
}

double Slice::Eval(int channel, double log_cos) const {
  double f = 0;
  for (int k = 0; k < lobe_count_; ++k) f += EvalLobe(lobe(channel, k), log_cos);
  return f;
}

double Slice::EvalWithGradient(int channel, double log_cos, double* gradient) const {
  double f = 0;
  for (int k = 0; k < lobe_count_; ++k) {
    const LobeSlopes slopes = lobes_[channel][k].Slopes(log_cos);
    f += slopes.f_r;
    gradient[2 * k] = slopes.by_log_kappa;
    gradient[2 * k + 1] = slopes.by_log_gamma;
  }
  return f;
}

}  // namespace gonio
