// SPDX-License-Identifier: Apache-2.0
#include "brdf/metrics.h"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <thread>
#include <vector>

#include "brdf/merl_table.h"
#include "core/error.h"

namespace gonio {
namespace {

constexpr double kLogRelativeEpsilon = 1e-3;

// Sums over the cells of one theta_h row. Rows are added up in order, whoever computed them: that
// is what makes the result independent of the number of threads.
struct Sums {
  double weight = 0;
  Rgb male = Rgb::Zero();
  double log_relative = 0, square = 0, cube_root = 0, log_square = 0;
  int compared = 0, missing = 0;

  void Add(const Sums& row) {
    weight += row.weight;
    male += row.male;
    log_relative += row.log_relative;
    square += row.square;
    cube_root += row.cube_root;
    log_square += row.log_square;
    compared += row.compared;
    missing += row.missing;
  }
};

void AddCell(const Rgb& f, const Rgb& g_raw, double cos_i, double cos_o, double weight,
             Sums* sums) {
  const Rgb g = g_raw.max(0);
  const Rgb log_ratio = ((1 + f * cos_i) / (1 + g * cos_i)).log();
  sums->male += weight * log_ratio.abs();
  sums->weight += weight;
  ++sums->compared;
  const double c = cos_i * cos_o;
  sums->log_relative +=
      ((f * c + kLogRelativeEpsilon) / (g * c + kLogRelativeEpsilon)).log().square().sum();
  sums->square += (f - g_raw).square().sum();
  sums->log_square += log_ratio.square().sum();
  for (int k = 0; k < kChannels; ++k) {
    const double root = std::cbrt(f[k] * cos_i) - std::cbrt(g_raw[k] * cos_i);
    sums->cube_root += root * root;
  }
}

// A BRDF at the centre of a cell; tables are read there without interpolating.
class CellSource {
 public:
  explicit CellSource(const Brdf& brdf)
      : brdf_(brdf), table_(dynamic_cast<const MerlTable*>(&brdf)) {}

  std::optional<Rgb> operator()(int h, int d, int p, const HalfDiff& angles) const {
    return table_ != nullptr ? table_->Cell(h, d, p) : brdf_.Eval(angles);
  }

 private:
  const Brdf& brdf_;
  const MerlTable* table_;
};

using Cosine = std::array<double, MerlTable::kPhiD>;

Cosine PhiCosines() {
  Cosine cosines;
  for (int p = 0; p < MerlTable::kPhiD; ++p) {
    cosines[p] = std::cos(MerlTable::CellCentre(0, 0, p).phi_d);
  }
  return cosines;
}

Sums CompareRow(int h, const CellSource& reference, const CellSource& other, const Cosine& cos_phi,
                const MetricOptions& options) {
  Sums sums;
  const double weight = MerlTable::ThetaHWidth(h);
  const double min_cosine = std::cos(options.max_theta);
  for (int d = 0; d < MerlTable::kThetaD; ++d) {
    const HalfDiff row = MerlTable::CellCentre(h, d, 0);
    const double along = std::cos(row.theta_d) * std::cos(row.theta_h);
    const double across = std::sin(row.theta_d) * std::sin(row.theta_h);
    for (int p = 0; p < MerlTable::kPhiD; p += options.phi_stride) {
      const double cos_i = along - across * cos_phi[p];
      const double cos_o = along + across * cos_phi[p];
      if (!(cos_i > min_cosine && cos_o > min_cosine)) continue;
      const HalfDiff angles = MerlTable::CellCentre(h, d, p);
      const std::optional<Rgb> f = reference(h, d, p, angles);
      if (!f || !f->isFinite().all()) continue;
      const std::optional<Rgb> g = other(h, d, p, angles);
      if (g && g->isFinite().all()) {
        AddCell(*f, *g, cos_i, cos_o, weight, &sums);
      } else {
        ++sums.missing;
      }
    }
  }
  return sums;
}

Sums CompareCells(const CellSource& reference, const CellSource& other,
                  const MetricOptions& options) {
  options.Check();
  const Cosine cos_phi = PhiCosines();
  std::vector<Sums> rows(MerlTable::kThetaH);
  const auto work = [&](int first) {
    for (int h = first; h < MerlTable::kThetaH; h += options.threads) {
      rows[h] = CompareRow(h, reference, other, cos_phi, options);
    }
  };
  {
    std::vector<std::jthread> helpers;
    for (int t = 1; t < options.threads; ++t) helpers.emplace_back(work, t);
    work(0);
  }
  Sums total;
  for (const Sums& row : rows) total.Add(row);
  return total;
}

ErrorMetrics ToMetrics(const Sums& sums) {
  const double terms = static_cast<double>(sums.compared) * kChannels;
  ErrorMetrics metrics;
  metrics.male_per_channel = sums.male / sums.weight;
  metrics.male = metrics.male_per_channel.mean();
  metrics.log_relative_rms = std::sqrt(sums.log_relative / terms);
  metrics.mse = sums.square / terms;
  metrics.rms = std::sqrt(metrics.mse);
  metrics.cube_root_rms = std::sqrt(sums.cube_root / terms);
  metrics.log_mse = sums.log_square / terms;
  metrics.compared = sums.compared;
  metrics.missing = sums.missing;
  return metrics;
}

}  // namespace

void MetricOptions::Check() const {
  if (!(max_theta > 0 && max_theta <= kPi / 2)) {
    throw ConfigError(
        fmt::format("max_theta: is {} deg, must be > 0 and <= 90", DegFromRad(max_theta)));
  }
  if (phi_stride < 1 || phi_stride > MerlTable::kPhiD) {
    throw ConfigError(
        fmt::format("phi_stride: is {}, must be between 1 and {}", phi_stride, MerlTable::kPhiD));
  }
  if (threads < 1) throw ConfigError(fmt::format("threads: is {}, must be >= 1", threads));
}

ErrorMetrics Compare(const Brdf& reference, const Brdf& other, const MetricOptions& options) {
  return ToMetrics(CompareCells(CellSource(reference), CellSource(other), options));
}

}  // namespace gonio
