// SPDX-License-Identifier: Apache-2.0
// Summaries of numbers, some of which may be missing (NaN).

#pragma once

#include <utility>
#include <vector>

namespace gonio {

// The q-quantile, 0 .. 1, interpolated linearly between the sorted numbers (type 7 of Hyndman &
// Fan, "Sample Quantiles in Statistical Packages", 1996). NaN are left out; infinite ones are not,
// and neither is a quantile that lies beside one. NaN if there are none.
double Quantile(std::vector<double> numbers, double q);
inline double Median(std::vector<double> numbers) { return Quantile(std::move(numbers), 0.5); }

// Of the finite ones; NaN if there are none.
double MeanOf(const std::vector<double>& numbers);

}  // namespace gonio
