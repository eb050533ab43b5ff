// SPDX-License-Identifier: Apache-2.0
#include "apps/gonio/statistics.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace gonio {

double Quantile(std::vector<double> numbers, double q) {
  std::erase_if(numbers, [](double x) { return std::isnan(x); });
  if (numbers.empty()) return std::numeric_limits<double>::quiet_NaN();
  std::sort(numbers.begin(), numbers.end());
  const double at = q * static_cast<double>(numbers.size() - 1);
  const auto below = static_cast<std::size_t>(at);
  const double share = at - static_cast<double>(below);
  // Without this 0 x infinity would spoil what lies on a finite number.
  if (share == 0) return numbers[below];
  return (1 - share) * numbers[below] + share * numbers[below + 1];
}

double MeanOf(const std::vector<double>& numbers) {
  double sum = 0;
  int count = 0;
  for (const double x : numbers) {
    if (!std::isfinite(x)) continue;
    sum += x;
    ++count;
  }
  return count > 0 ? sum / count : std::numeric_limits<double>::quiet_NaN();
}

}  // namespace gonio
