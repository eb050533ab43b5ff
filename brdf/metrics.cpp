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
  Rgb weight = Rgb::Zero(), male = Rgb::Zero();
  Rgb count = Rgb::Zero(), log_relative = Rgb::Zero(), square = Rgb::Zero(),
      cube_root = Rgb::Zero(), log_square = Rgb::Zero();
  Rgb table_count = Rgb::Zero(), table_square = Rgb::Zero();
  int compared = 0, missing = 0;

  void Add(const Sums& row) {
    weight += row.weight;
    male += row.male;
    count += row.count;
    log_relative += row.log_relative;
    square += row.square;
    cube_root += row.cube_root;
    log_square += row.log_square;
    table_count += row.table_count;
    table_square += row.table_square;
    compared += row.compared;
    missing += row.missing;
  }
};

// One cell of the range that counts. `known`: 1 for the channels that are finite in g, else 0,
// where g has been set to f.
void AddCell(const Rgb& f_raw, const Rgb& g_raw, const Rgb& known, double cos_i, double cos_o,
             double weight, Sums* sums) {
  const Rgb f = f_raw.max(0);
  const Rgb g = g_raw.max(0);
  const Rgb log_ratio = ((1 + f * cos_i) / (1 + g * cos_i)).log() * known;
  sums->male += weight * log_ratio.abs();
  sums->weight += weight * known;
  sums->count += known;
  ++sums->compared;
  const double c = cos_i * cos_o;
  sums->log_relative +=
      ((f * c + kLogRelativeEpsilon) / (g * c + kLogRelativeEpsilon)).log().square() * known;
  sums->square += (f_raw - g_raw).square();
  sums->log_square += log_ratio.square();
  for (int k = 0; k < kChannels; ++k) {
    const double root = std::cbrt(f_raw[k] * cos_i) - std::cbrt(g_raw[k] * cos_i);
    sums->cube_root[k] += root * root;
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

// What both know of a cell.
struct Pair {
  Rgb f, g;   // g is f where it is not known
  Rgb known;  // 1 or 0
};

// Empty if the reference knows nothing; `missing` is set if only the other one does not.
std::optional<Pair> Look(const CellSource& reference, const CellSource& other, int h, int d, int p,
                         bool* missing) {
  const HalfDiff angles = MerlTable::CellCentre(h, d, p);
  *missing = false;
  const std::optional<Rgb> f = reference(h, d, p, angles);
  if (!f || !f->isFinite().all()) return std::nullopt;
  const std::optional<Rgb> g = other(h, d, p, angles);
  *missing = !g || !g->isFinite().any();
  if (*missing) return std::nullopt;
  return Pair{*f, g->isFinite().select(*g, *f), g->isFinite().cast<double>()};
}

// Calls cell(d, p, cos_i, cos_o) for each physical cell of a row that the strides do not skip.
// Each row skips other theta_d: every theta_h counts, and no stripes can beat with the material's.
template <typename Cell>
void ForEachCell(int h, const Cosine& cos_phi, const MetricOptions& options, const Cell& cell) {
  const int stride = options.theta_d_stride;
  for (int d = h % stride; d < MerlTable::kThetaD; d += stride) {
    const HalfDiff row = MerlTable::CellCentre(h, d, 0);
    const double along = std::cos(row.theta_d) * std::cos(row.theta_h);
    const double across = std::sin(row.theta_d) * std::sin(row.theta_h);
    for (int p = 0; p < MerlTable::kPhiD; p += options.phi_stride) {
      const double cos_i = along - across * cos_phi[p];
      const double cos_o = along + across * cos_phi[p];
      if (cos_i > 0 && cos_o > 0) cell(d, p, cos_i, cos_o);
    }
  }
}

Sums CompareRow(int h, const CellSource& reference, const CellSource& other, const Cosine& cos_phi,
                const MetricOptions& options) {
  Sums sums;
  const double weight = MerlTable::ThetaHWidth(h);
  const double min_cosine = std::cos(options.max_theta);
  ForEachCell(h, cos_phi, options, [&](int d, int p, double cos_i, double cos_o) {
    const bool counts = cos_i > min_cosine && cos_o > min_cosine;
    bool missing = false;
    const std::optional<Pair> pair = Look(reference, other, h, d, p, &missing);
    if (missing && counts) ++sums.missing;
    if (!pair) return;
    sums.table_count += pair->known;
    sums.table_square += (pair->f - pair->g).square();
    if (counts) AddCell(pair->f, pair->g, pair->known, cos_i, cos_o, weight, &sums);
  });
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

// The mean over all channels that could be compared, and over each.
double Mean(const Rgb& sum, const Rgb& count, Rgb* per_channel) {
  *per_channel = sum / count;
  return sum.sum() / count.sum();
}

ErrorMetrics ToMetrics(const Sums& sums) {
  ErrorMetrics m;
  m.male = Mean(sums.male, sums.weight, &m.male_per_channel);
  m.log_relative_rms =
      std::sqrt(Mean(sums.log_relative, sums.count, &m.log_relative_rms_per_channel));
  m.log_relative_rms_per_channel = m.log_relative_rms_per_channel.sqrt();
  m.mse = Mean(sums.square, sums.count, &m.mse_per_channel);
  m.rms = std::sqrt(m.mse);
  m.cube_root_rms = std::sqrt(Mean(sums.cube_root, sums.count, &m.cube_root_rms_per_channel));
  m.cube_root_rms_per_channel = m.cube_root_rms_per_channel.sqrt();
  m.log_mse = Mean(sums.log_square, sums.count, &m.log_mse_per_channel);
  m.table_mse = Mean(sums.table_square, sums.table_count, &m.table_mse_per_channel);
  m.compared = sums.compared;
  m.missing = sums.missing;
  return m;
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
  if (theta_d_stride < 1 || theta_d_stride > MerlTable::kThetaD) {
    throw ConfigError(fmt::format("theta_d_stride: is {}, must be between 1 and {}", theta_d_stride,
                                  MerlTable::kThetaD));
  }
  if (threads < 1) throw ConfigError(fmt::format("threads: is {}, must be >= 1", threads));
}

ErrorMetrics Compare(const Brdf& reference, const Brdf& other, const MetricOptions& options) {
  return ToMetrics(CompareCells(CellSource(reference), CellSource(other), options));
}

std::vector<double> ErrorMap(const Brdf& reference, const Brdf& other, int channel,
                             const MetricOptions& options) {
  options.Check();
  const CellSource f(reference);
  const CellSource g(other);
  const Cosine cos_phi = PhiCosines();
  const double min_cosine = std::cos(options.max_theta);
  std::vector<double> sums(std::size_t{MerlTable::kThetaH} * MerlTable::kThetaD, 0.0);
  std::vector<int> counts(sums.size(), 0);
  for (int h = 0; h < MerlTable::kThetaH; ++h) {
    ForEachCell(h, cos_phi, options, [&](int d, int p, double cos_i, double cos_o) {
      bool missing = false;
      if (!(cos_i > min_cosine && cos_o > min_cosine)) return;
      const std::optional<Pair> pair = Look(f, g, h, d, p, &missing);
      if (!pair || pair->known[channel] == 0) return;
      const std::size_t cell = std::size_t(h) * MerlTable::kThetaD + d;
      sums[cell] += std::abs(std::log1p(std::max(pair->f[channel], 0.0) * cos_i) -
                             std::log1p(std::max(pair->g[channel], 0.0) * cos_i));
      ++counts[cell];
    });
  }
  for (std::size_t cell = 0; cell < sums.size(); ++cell) sums[cell] /= counts[cell];  // 0/0: NaN
  return sums;
}

}  // namespace gonio
