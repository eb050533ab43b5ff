// SPDX-License-Identifier: Apache-2.0
#include "acquisition/radiometry/linearity.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace gonio {
namespace {

constexpr double kNoClipping = 1e-3;      // fraction of clipped sites
constexpr double kNormalQuantile = 3.09;  // one-sided, of one in a thousand
constexpr double kNoNoise = 1e-9;         // relative, stands in for none

double Square(double x) { return x * x; }

// Quantile of chi squared (Wilson and Hilferty, 1931).
double ChiSquaredLimit(int degrees_of_freedom) {
  const double k = 2.0 / (9 * degrees_of_freedom);
  return degrees_of_freedom * std::pow(1 - k + kNormalQuantile * std::sqrt(k), 3);
}

Error Refusal(const std::string& why) { return {ErrorCode::kRefused, "linearity: " + why}; }

struct Level {
  double light = 0;     // s
  double counts = 0;    // as read, dark included
  double dark = 0;      // counts that came without light
  double relative = 0;  // sigma of the deviation
};

std::vector<Level> LevelsOf(const std::vector<TransferPoint>& points,
                            const LinearityOptions& options) {
  std::vector<Level> levels;
  for (const TransferPoint& p : points) {
    if (p.channel != options.channel || p.clipped > kNoClipping) continue;
    if (!(p.mean > std::max(0.0, options.min_counts))) continue;
    Level level;
    level.light = p.exposure * p.monitor;
    level.counts = p.mean;
    level.dark = options.dark_rate * p.exposure;
    // Two frames, each with its own draw of the light.
    level.relative = std::hypot(p.mean_sigma / p.mean, options.light_noise / std::sqrt(2.0));
    level.relative = std::max(level.relative, kNoNoise);
    if (level.light > 0) levels.push_back(level);
  }
  std::sort(levels.begin(), levels.end(),
            [](const Level& a, const Level& b) { return a.counts < b.counts; });
  return levels;
}

}  // namespace

Linearity Linearity::Identity(double max_counts) {
  Linearity table;
  table.knots_ = {{max_counts, {1, 0}}};
  return table;
}

Result<Linearity> Linearity::FromKnots(std::vector<LinearityKnot> knots) {
  if (knots.empty()) return Refusal("no knots");
  std::sort(knots.begin(), knots.end(),
            [](const auto& a, const auto& b) { return a.counts < b.counts; });
  for (std::size_t i = 0; i < knots.size(); ++i) {
    const LinearityKnot& knot = knots[i];
    if (!(knot.counts > 0) || !(knot.factor.value > 0) || !(knot.factor.sigma >= 0)) {
      return Refusal("a knot's counts and factor must be > 0, its sigma >= 0");
    }
    if (i > 0 && knot.counts == knots[i - 1].counts) {
      return Refusal(fmt::format("two knots at {} counts", knot.counts));
    }
  }
  Linearity table;
  table.knots_ = std::move(knots);
  return table;
}

std::optional<MeasuredValue> Linearity::Factor(double counts) const {
  if (!(counts <= max_counts())) return std::nullopt;
  const auto above =
      std::lower_bound(knots_.begin(), knots_.end(), counts,
                       [](const LinearityKnot& knot, double c) { return knot.counts < c; });
  if (above == knots_.begin()) return above->factor;
  const LinearityKnot& a = *(above - 1);
  const LinearityKnot& b = *above;
  const double w = (counts - a.counts) / (b.counts - a.counts);
  return MeasuredValue{(1 - w) * a.factor.value + w * b.factor.value,
                       std::hypot((1 - w) * a.factor.sigma, w * b.factor.sigma)};
}

std::optional<double> Linearity::Correct(double counts) const {
  const auto factor = Factor(counts);
  if (!factor) return std::nullopt;
  return factor->value * counts;
}

bool Linearity::is_identity() const {
  return std::all_of(knots_.begin(), knots_.end(),
                     [](const LinearityKnot& k) { return k.factor.value == 1; });
}

Result<LinearityFit> MeasureLinearity(const std::vector<TransferPoint>& points,
                                      const LinearityOptions& options) {
  const std::vector<Level> levels = LevelsOf(points, options);
  if (levels.size() < 3) {
    return Refusal(fmt::format("{} unsaturated exposures, needs 3", levels.size()));
  }
  // The weights are those of counts / light, whose relative noise is the same everywhere but for
  // the faintest points.
  double weights = 0;
  double weighted = 0;
  for (const Level& level : levels) {
    weights += 1 / Square(level.relative);
    weighted += (level.counts - level.dark) / level.light / Square(level.relative);
  }
  LinearityFit fit;
  fit.slope = weighted / weights;
  if (!(fit.slope > 0)) return Refusal("the counts do not grow with the light");
  std::vector<LinearityKnot> knots;
  for (const Level& level : levels) {
    const double factor = (fit.slope * level.light + level.dark) / level.counts;
    // The line itself follows this point by its share of the weights.
    const double share = 1 / Square(level.relative) / weights;
    const double sigma = level.relative * std::sqrt(std::max(0.0, 1 - share));
    knots.push_back({level.counts, {factor, factor * sigma}});
    const double residual = 1 / factor - 1;
    fit.chi_squared += Square((factor - 1) / level.relative);
    if (std::abs(residual) > std::abs(fit.max_residual)) {
      fit.max_residual = std::abs(residual);
      fit.max_residual_sigma = sigma;
    }
  }
  fit.degrees_of_freedom = static_cast<int>(levels.size()) - 1;
  fit.significant = fit.chi_squared > ChiSquaredLimit(fit.degrees_of_freedom);
  auto table = Linearity::FromKnots(std::move(knots));
  if (!table) return table.error();
  fit.table = std::move(table).value();
  return fit;
}

}  // namespace gonio
