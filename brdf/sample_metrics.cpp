// SPDX-License-Identifier: Apache-2.0
#include "brdf/sample_metrics.h"

#include <algorithm>
#include <cmath>
#include <optional>

namespace gonio {

SampleMetrics CompareSamples(std::span<const BrdfSample> samples, const Brdf& other,
                             double max_theta) {
  // Angles that went through a file in degrees are at the edge, not beyond it.
  constexpr double kRounding = 1e-9;
  const double min_cos = std::cos(max_theta) + kRounding;
  SampleMetrics m;
  for (const BrdfSample& sample : samples) {
    const DirectionPair& pair = sample.directions;
    const double cos_i = pair.cos_theta_i();
    const double cosines = cos_i * pair.cos_theta_o();
    const bool scored = std::min(cos_i, pair.cos_theta_o()) > min_cos;
    const std::optional<Rgb> g_r = scored ? other.Eval(pair) : std::nullopt;
    for (int c = 0; c < kChannels; ++c) {
      if (!g_r || !std::isfinite((*g_r)[c]) || !std::isfinite(sample.sigma[c])) {
        ++m.left_out;
        continue;
      }
      const double f = std::max(sample.f_r[c], 0.0);
      const double g = std::max((*g_r)[c], 0.0);
      const double difference = sample.f_r[c] - (*g_r)[c];
      m.male += std::abs(std::log1p(f * cos_i) - std::log1p(g * cos_i));
      m.log_relative_rms += std::pow(std::log((f * cosines + 1e-3) / (g * cosines + 1e-3)), 2);
      m.rms += difference * difference;
      m.z_rms += std::pow(difference / sample.sigma[c], 2);
      ++m.readings;
    }
  }
  const double n = m.readings;  // 0 / 0: NaN
  m.male /= n;
  for (double* sum : {&m.log_relative_rms, &m.rms, &m.z_rms}) *sum = std::sqrt(*sum / n);
  return m;
}

}  // namespace gonio
