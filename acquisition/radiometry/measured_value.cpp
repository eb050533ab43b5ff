// SPDX-License-Identifier: Apache-2.0
#include "acquisition/radiometry/measured_value.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/check.h"

namespace gonio {

double MeasuredValue::relative() const {
  return value == 0 ? std::numeric_limits<double>::infinity() : sigma / std::abs(value);
}

std::optional<LineFit> FitLine(std::span<const double> x, std::span<const double> y,
                               std::span<const double> sigmas) {
  GONIO_CHECK(x.size() == y.size() && x.size() == sigmas.size(), "one sigma for each point");
  double sum = 0;
  double sum_x = 0;
  double sum_y = 0;
  for (std::size_t i = 0; i < x.size(); ++i) {
    const double weight = 1 / (sigmas[i] * sigmas[i]);
    sum += weight;
    sum_x += weight * x[i];
    sum_y += weight * y[i];
  }
  // About the centre: the usual closed form loses digits when all x are far from zero.
  const double centre = sum_x / sum;
  double spread = 0;
  double slope = 0;
  for (std::size_t i = 0; i < x.size(); ++i) {
    const double weight = 1 / (sigmas[i] * sigmas[i]);
    spread += weight * (x[i] - centre) * (x[i] - centre);
    slope += weight * (x[i] - centre) * y[i];
  }
  if (!(spread > 0)) return std::nullopt;
  slope /= spread;
  LineFit fit;
  fit.slope = {slope, 1 / std::sqrt(spread)};
  fit.intercept = {sum_y / sum - slope * centre, std::sqrt(1 / sum + centre * centre / spread)};
  fit.covariance = -centre / spread;
  for (std::size_t i = 0; i < x.size(); ++i) {
    const double residual = (y[i] - fit.intercept.value - slope * x[i]) / sigmas[i];
    fit.chi_squared += residual * residual;
  }
  fit.degrees_of_freedom = static_cast<int>(x.size()) - 2;
  return fit;
}

double Median(std::vector<float> values) {
  if (values.empty()) return std::numeric_limits<double>::quiet_NaN();
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  if (values.size() % 2 == 1) return *middle;
  return 0.5 * (double{*std::max_element(values.begin(), middle)} + *middle);
}

RobustSpread RobustSpreadOf(const std::vector<float>& values) {
  RobustSpread spread;
  spread.median = Median(values);
  std::vector<float> deviations;
  deviations.reserve(values.size());
  for (const float v : values)
    deviations.push_back(static_cast<float>(std::abs(v - spread.median)));
  spread.sigma = 1.4826 * Median(std::move(deviations));
  return spread;
}

}  // namespace gonio
