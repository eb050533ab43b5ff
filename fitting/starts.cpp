// SPDX-License-Identifier: Apache-2.0
#include "fitting/starts.h"

#include <algorithm>
#include <cmath>

#include "core/units.h"
#include "fitting/slice.h"

namespace gonio {
namespace {

// gamma of the narrowest lobe: half widths of about 17, 7, 3 and 1.2 degrees.
constexpr double kNarrowGammas[] = {15, 80, 400, 3000};

// What a channel's readings say before any fit [1/sr].
struct Levels {
  double diffuse = 0.05;
  double peak = 0.5;  // above the diffuse level
};

Levels LevelsOf(std::span<const BrdfSample> samples, int channel) {
  std::vector<double> wide;
  double peak = 0;
  for (const BrdfSample& sample : samples) {
    const double f = sample.f_r[channel];
    if (!std::isfinite(sample.sigma[channel])) continue;
    const HalfDiff angles = ToHalfDiff(sample.directions);
    if (angles.theta_h > RadFromDeg(35) && angles.theta_d < RadFromDeg(65)) wide.push_back(f);
    if (angles.theta_d < RadFromDeg(65)) peak = std::max(peak, f);
  }
  Levels levels;
  if (!wide.empty()) {
    const auto middle = wide.begin() + static_cast<std::ptrdiff_t>(wide.size() / 2);
    std::nth_element(wide.begin(), middle, wide.end());
    levels.diffuse = std::max(*middle, 1e-3);
  }
  levels.peak = std::max(peak - levels.diffuse, 0.1 * levels.diffuse);
  return levels;
}

void SetLevel(const DsbrdfShape& shape, int channel, int lobe, double height,
              Eigen::VectorXd* parameters) {
  parameters->segment(shape.Index(channel, lobe, 0), shape.knots)
      .setConstant(std::log(std::log1p(height)));
}

}  // namespace

std::vector<Eigen::VectorXd> FitStarts(std::span<const BrdfSample> samples, const Prior& prior) {
  const DsbrdfShape& shape = prior.shape;
  std::vector<Eigen::VectorXd> starts = {prior.mean};
  for (const double gamma : kNarrowGammas) {
    Eigen::VectorXd start = prior.mean;
    for (int c = 0; c < kChannels; ++c) {
      const Levels levels = LevelsOf(samples, c);
      const int narrow = shape.lobes - 1;
      if (narrow > 0) SetLevel(shape, c, 0, levels.diffuse, &start);
      for (int k = 1; k < narrow; ++k) SetLevel(shape, c, k, 0.1 * levels.peak, &start);
      SetLevel(shape, c, narrow, levels.peak, &start);
      start.segment(shape.Index(c, narrow, 1), shape.knots).setConstant(std::log(gamma));
    }
    starts.push_back(std::move(start));
  }
  return starts;
}

}  // namespace gonio
