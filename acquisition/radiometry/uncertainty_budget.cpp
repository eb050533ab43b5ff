// SPDX-License-Identifier: Apache-2.0
#include "acquisition/radiometry/uncertainty_budget.h"

#include <algorithm>
#include <cmath>

#include "acquisition/radiometry/dark_library.h"
#include "core/check.h"

namespace gonio {
namespace {

using Term = UncertaintyTerm;

constexpr std::array<const char*, kUncertaintyTerms> kNames = {
    "shot",      "read",           "rounding",    "multiplicative", "monitor", "dark", "flat",
    "linearity", "exposure_ratio", "stray_light", "responsivity",   "angle",   "drift"};

Rgb SumOfSquares(const UncertaintyBudget& budget, bool systematic) {
  Rgb sum = Rgb::Zero();
  for (int i = 0; i < kUncertaintyTerms; ++i) {
    const auto term = static_cast<Term>(i);
    if (IsSystematic(term) == systematic) sum += budget[term].square();
  }
  return sum;
}

}  // namespace

const char* ToString(UncertaintyTerm term) { return kNames[static_cast<std::size_t>(term)]; }

bool IsSystematic(UncertaintyTerm term) { return term >= Term::kDark; }

Rgb UncertaintyBudget::random() const { return SumOfSquares(*this, false).sqrt(); }
Rgb UncertaintyBudget::systematic() const { return SumOfSquares(*this, true).sqrt(); }
Rgb UncertaintyBudget::combined() const {
  return (SumOfSquares(*this, false) + SumOfSquares(*this, true)).sqrt();
}

UncertaintyBudget BudgetOfMean(const UncertaintyBudget& one, int n) {
  GONIO_CHECK(n >= 1, "a mean of something");
  UncertaintyBudget mean = one;
  for (int i = 0; i < kUncertaintyTerms; ++i) {
    const auto term = static_cast<Term>(i);
    if (!IsSystematic(term)) mean[term] /= std::sqrt(static_cast<double>(n));
  }
  return mean;
}

void SetNoise(const NoiseInputs& in, int channel, UncertaintyBudget* budget) {
  GONIO_CHECK(in.gain_f_r > 0 && in.sites >= 1, "light on some sites");
  const double signal = std::max(in.f_r, 0.0) * in.gain_f_r;
  const double site = signal + in.dark;
  const double read = in.read_noise * in.read_noise;
  const double alone = 1 / in.sites;
  const double square = in.count * in.count;
  const double rounding = square * (alone / 12 + SharedRounding((site + read) / square));
  UncertaintyBudget& b = *budget;
  b[Term::kShot][channel] = std::sqrt(site * alone) / in.gain_f_r;
  b[Term::kRead][channel] = std::sqrt(read * alone) / in.gain_f_r;
  b[Term::kRounding][channel] = std::sqrt(rounding) / in.gain_f_r;
  b[Term::kMultiplicative][channel] = in.multiplicative * signal / in.gain_f_r;
  b[Term::kMonitor][channel] = in.monitor * signal / in.gain_f_r;
}

double AngleTerm(double f_r, double slope, double theta_i, double sigma_theta) {
  return std::abs(sigma_theta) * std::hypot(slope, f_r * std::tan(theta_i));
}

}  // namespace gonio
