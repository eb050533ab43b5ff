// SPDX-License-Identifier: Apache-2.0
#include "fitting/slice_fit.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/units.h"

namespace gonio {
namespace {

constexpr double kNegativeShare = 0.05;
constexpr double kBroadest = 0.5;
constexpr double kDiffuseBeyond = RadFromDeg(30);

std::vector<SlicePoint> Valid(std::span<const SlicePoint> points) {
  std::vector<SlicePoint> valid;
  std::copy_if(points.begin(), points.end(), std::back_inserter(valid),
               [](const SlicePoint& point) { return point.cells > 0; });
  return valid;
}

bool LessBright(const SlicePoint& a, const SlicePoint& b) { return a.f_r < b.f_r; }

// Median f_r beyond 30 deg, or of all points if there are none.
double DiffuseLevel(std::span<const SlicePoint> valid) {
  std::vector<double> levels;
  for (const SlicePoint& point : valid) {
    if (point.theta_h > kDiffuseBeyond) levels.push_back(point.f_r);
  }
  if (levels.empty()) {
    for (const SlicePoint& point : valid) levels.push_back(point.f_r);
  }
  std::nth_element(levels.begin(), levels.begin() + levels.size() / 2, levels.end());
  return levels[levels.size() / 2];
}

}  // namespace

std::optional<std::string> WhyNotFittable(std::span<const SlicePoint> points, int lobes) {
  if (points.empty()) return "holds no reading";
  const std::vector<SlicePoint> valid = Valid(points);
  if (valid.empty()) return "no reading is valid";
  if (static_cast<int>(valid.size()) < 2 * lobes) {
    return fmt::format("{} valid readings for the {} parameters of {} lobes", valid.size(),
                       2 * lobes, lobes);
  }
  const SlicePoint& least = *std::min_element(valid.begin(), valid.end(), LessBright);
  const SlicePoint& most = *std::max_element(valid.begin(), valid.end(), LessBright);
  if (least.f_r == 0 && most.f_r == 0) return "every reading is zero";
  if (least.f_r < -kNegativeShare * std::max(most.f_r, 0.0)) {
    return fmt::format("f_r = {:.4g} / sr at theta_h {:.2f} deg: negative", least.f_r,
                       DegFromRad(least.theta_h));
  }
  return std::nullopt;
}

bool IsConstant(std::span<const SlicePoint> points) {
  const std::vector<SlicePoint> valid = Valid(points);
  const auto [least, most] = std::minmax_element(valid.begin(), valid.end(), LessBright);
  return least == valid.end() || most->f_r - least->f_r <= 1e-6 * std::abs(most->f_r);
}

std::vector<Lobe> StartingLobes(std::span<const SlicePoint> points, int lobes, double narrowest) {
  const std::vector<SlicePoint> valid = Valid(points);
  const double peak = std::max(std::max_element(valid.begin(), valid.end(), LessBright)->f_r, 1e-4);
  const double level = std::clamp(DiffuseLevel(valid), 1e-2 * peak, peak);
  std::vector<Lobe> start;
  for (int k = 0; k < lobes; ++k) {
    const double position = lobes == 1 ? 0 : k / (lobes - 1.0);
    const double height = level * std::pow(peak / level, position);
    start.push_back({.kappa = std::log1p(height),
                     .gamma = kBroadest * std::pow(narrowest / kBroadest, position)});
  }
  return start;
}

}  // namespace gonio
