// SPDX-License-Identifier: Apache-2.0
// Numbers with their standard uncertainty, and the small statistics that radiometry needs.

#pragma once

#include <optional>
#include <span>
#include <vector>

namespace gonio {

// A value and its standard uncertainty (JCGM 100:2008, GUM, 2.3.1), in the same unit.
struct MeasuredValue {
  double value = 0;
  double sigma = 0;  // >= 0

  // sigma / |value|; infinite for a value of zero.
  double relative() const;
};

// y = intercept + slope x, by weighted least squares.
struct LineFit {
  MeasuredValue intercept;
  MeasuredValue slope;
  double covariance = 0;   // of the two
  double chi_squared = 0;  // expected: degrees_of_freedom
  int degrees_of_freedom = 0;
};
// `sigmas`: standard uncertainties of the y, > 0. Empty if fewer than two different x are given.
std::optional<LineFit> FitLine(std::span<const double> x, std::span<const double> y,
                               std::span<const double> sigmas);

// The middle value, the mean of the two middle ones of an even number; NaN of nothing.
double Median(std::vector<float> values);

// Median and the spread that a normal distribution with the same median absolute deviation has:
// 1.4826 MAD. Half of the values may be wild without moving either far (Rousseeuw and Croux, 1993).
struct RobustSpread {
  double median = 0;
  double sigma = 0;
};
RobustSpread RobustSpreadOf(const std::vector<float>& values);

}  // namespace gonio
