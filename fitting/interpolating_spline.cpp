// SPDX-License-Identifier: Apache-2.0
#include "fitting/interpolating_spline.h"

#include <algorithm>

#include "core/check.h"

namespace gonio {
namespace {

// Slopes that make the second derivative continuous and zero at the ends: a tridiagonal system,
// solved by elimination without pivoting, as it is diagonally dominant.
std::vector<double> NaturalSlopes(const std::vector<double>& x, const std::vector<double>& y) {
  const std::size_t n = x.size();
  std::vector<double> diagonal(n), above(n), right(n);
  const auto secant = [&](std::size_t i) { return (y[i + 1] - y[i]) / (x[i + 1] - x[i]); };
  for (std::size_t i = 0; i < n; ++i) {
    const double before = i > 0 ? 1 / (x[i] - x[i - 1]) : 0;
    const double after = i + 1 < n ? 1 / (x[i + 1] - x[i]) : 0;
    diagonal[i] = 2 * (before + after);
    above[i] = after;
    right[i] = 3 * ((i > 0 ? before * secant(i - 1) : 0) + (i + 1 < n ? after * secant(i) : 0));
    if (i > 0) {
      const double factor = before / diagonal[i - 1];
      diagonal[i] -= factor * above[i - 1];
      right[i] -= factor * right[i - 1];
    }
  }
  std::vector<double> slope(n);
  for (std::size_t i = n; i-- > 0;) {
    slope[i] = (right[i] - (i + 1 < n ? above[i] * slope[i + 1] : 0)) / diagonal[i];
  }
  return slope;
}

// Weighted harmonic mean of the secants on both sides, zero where they disagree in sign.
std::vector<double> MonotoneSlopes(const std::vector<double>& x, const std::vector<double>& y) {
  const std::size_t n = x.size();
  const auto width = [&](std::size_t i) { return x[i + 1] - x[i]; };
  const auto secant = [&](std::size_t i) { return (y[i + 1] - y[i]) / width(i); };
  std::vector<double> slope(n);
  slope.front() = secant(0);
  slope.back() = secant(n - 2);
  for (std::size_t i = 1; i + 1 < n; ++i) {
    const double before = secant(i - 1);
    const double after = secant(i);
    if (before * after <= 0) continue;
    const double w_before = 2 * width(i) + width(i - 1);
    const double w_after = width(i) + 2 * width(i - 1);
    slope[i] = (w_before + w_after) / (w_before / before + w_after / after);
  }
  return slope;
}

}  // namespace

InterpolatingSpline::InterpolatingSpline(std::vector<double> x, std::vector<double> y,
                                         SplineKind kind)
    : x_(std::move(x)), y_(std::move(y)) {
  GONIO_CHECK(!x_.empty() && x_.size() == y_.size(), "a y for each x");
  if (x_.size() == 1) {
    slope_ = {0};
  } else {
    slope_ = kind == SplineKind::kNatural ? NaturalSlopes(x_, y_) : MonotoneSlopes(x_, y_);
  }
}

double InterpolatingSpline::operator()(double x) const {
  if (x <= x_.front()) return y_.front();
  if (x >= x_.back()) return y_.back();
  const std::size_t i = std::upper_bound(x_.begin(), x_.end(), x) - x_.begin() - 1;
  const double width = x_[i + 1] - x_[i];
  const double t = (x - x_[i]) / width;
  // Hermite's cubic.
  const double s = 1 - t;
  return s * s * (1 + 2 * t) * y_[i] + t * t * (3 - 2 * t) * y_[i + 1] +
         s * t * width * (s * slope_[i] - t * slope_[i + 1]);
}

}  // namespace gonio
