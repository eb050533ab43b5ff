// SPDX-License-Identifier: Apache-2.0
#include "brdf/render/half_vector_sampler.h"

#include <algorithm>
#include <cmath>

#include "brdf/merl_table.h"
#include "core/units.h"

namespace gonio {
namespace {

constexpr int kCells = MerlTable::kThetaH;
// theta_d [rad] that the mean is over, across the half vector's plane: above the horizon
// everywhere.
constexpr double kThetaD[] = {RadFromDeg(2), RadFromDeg(20), RadFromDeg(40), RadFromDeg(60),
                              RadFromDeg(75)};

double LowerEdge(int h) {
  const double root = static_cast<double>(h) / kCells;
  return root * root * kPi / 2;
}

double MeanAt(const Brdf& brdf, double theta_h) {
  double sum = 0;
  for (const double theta_d : kThetaD) {
    const std::optional<Rgb> f_r = brdf.Eval(HalfDiff{theta_h, theta_d, kPi / 2});
    if (f_r && f_r->isFinite().all()) sum += std::max(f_r->mean(), 0.0);
  }
  return sum / std::size(kThetaD);
}

}  // namespace

HalfVectorSampler::HalfVectorSampler(const Brdf& brdf) : cdf_(kCells + 1, 0), density_(kCells, 0) {
  for (int h = 0; h < kCells; ++h) {
    const double theta_h = MerlTable::CellCentre(h, 0, 0).theta_h;
    // A little everywhere, so that no direction is impossible.
    density_[h] = (MeanAt(brdf, theta_h) + 1e-4) * std::cos(theta_h);
    const double solid_angle = 2 * kPi * (std::cos(LowerEdge(h)) - std::cos(LowerEdge(h + 1)));
    cdf_[h + 1] = cdf_[h] + density_[h] * solid_angle;
  }
  const double total = cdf_.back();
  for (double& share : cdf_) share /= total;
  for (double& density : density_) density /= total;
}

Eigen::Vector3d HalfVectorSampler::Draw(double u, double v) const {
  const auto end = std::upper_bound(cdf_.begin(), cdf_.end(), u);
  const int h = std::clamp(static_cast<int>(end - cdf_.begin()) - 1, 0, kCells - 1);
  const double within = (u - cdf_[h]) / (cdf_[h + 1] - cdf_[h]);
  // Uniform over the ring's solid angle; in sin^2(theta / 2), which keeps digits near the normal.
  const auto haversine = [](double theta) { return std::pow(std::sin(theta / 2), 2); };
  const double lower = haversine(LowerEdge(h));
  const double at = lower + within * (haversine(LowerEdge(h + 1)) - lower);
  return FromSpherical(2 * std::asin(std::sqrt(std::clamp(at, 0.0, 1.0))), 2 * kPi * v);
}

double HalfVectorSampler::Pdf(const Eigen::Vector3d& half) const {
  if (half.z() <= 0) return 0;
  const double theta_h = std::atan2(std::hypot(half.x(), half.y()), half.z());
  const int h = std::min(static_cast<int>(kCells * std::sqrt(theta_h * 2 / kPi)), kCells - 1);
  return density_[h];
}

}  // namespace gonio
