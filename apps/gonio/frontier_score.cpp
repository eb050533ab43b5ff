// SPDX-License-Identifier: Apache-2.0
#include "apps/gonio/frontier_score.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "brdf/merl_table.h"
#include "brdf/metrics.h"
#include "core/units.h"

namespace gonio {
namespace {

// Number of the MERL cell that holds a direction.
int CellOf(const HalfDiff& angles) {
  const auto index = [](double share, int count) {
    return std::clamp(static_cast<int>(share * count), 0, count - 1);
  };
  const int h = index(std::sqrt(angles.theta_h / (kPi / 2)), MerlTable::kThetaH);
  const int d = index(angles.theta_d / (kPi / 2), MerlTable::kThetaD);
  const int p = index(angles.phi_d / kPi, MerlTable::kPhiD);
  return (h * MerlTable::kThetaD + d) * MerlTable::kPhiD + p;
}

class Counter {
 public:
  Counter(const Brdf& truth, const Estimate& estimate, std::span<const BrdfSample> samples)
      : truth_(truth), estimate_(estimate) {
    for (const BrdfSample& sample : samples) {
      measured_.insert(CellOf(ToHalfDiff(sample.directions)));
    }
  }

  void Add(const HalfDiff& angles, double weight) {
    double cos_i = 0;
    double cos_o = 0;
    Cosines(angles, &cos_i, &cos_o);
    if (std::min(cos_i, cos_o) <= std::cos(RadFromDeg(80)) || measured_.count(CellOf(angles)) > 0) {
      return;
    }
    std::optional<Rgb> f_r = truth_.Eval(angles);
    if (!f_r) return;
    *f_r = f_r->max(0);  // colours out of gamut, as in the metrics
    weight_ += kChannels * weight;
    for (std::size_t k = 0; k < kIntervals.size(); ++k) {
      const Interval interval = estimate_.PredictInterval(angles, kIntervals[k]);
      const auto holds = *f_r >= interval.low && *f_r <= interval.high;
      inside_[k] += weight * static_cast<double>(holds.count());
    }
  }

  std::array<double, kIntervals.size()> Shares() const {
    std::array<double, kIntervals.size()> shares{};
    for (std::size_t k = 0; k < shares.size(); ++k) shares[k] = inside_[k] / weight_;  // 0/0: NaN
    return shares;
  }

 private:
  const Brdf& truth_;
  const Estimate& estimate_;
  std::set<int> measured_;
  double weight_ = 0;
  std::array<double, kIntervals.size()> inside_ = {};
};

}  // namespace

std::array<double, kIntervals.size()> Coverage(const Brdf& truth, const Estimate& estimate,
                                               std::span<const BrdfSample> samples,
                                               int theta_d_stride, int phi_stride) {
  Counter counter(truth, estimate, samples);
  for (int h = 0; h < MerlTable::kThetaH; ++h) {
    for (int d = h % theta_d_stride; d < MerlTable::kThetaD; d += theta_d_stride) {
      for (int p = 0; p < MerlTable::kPhiD; p += phi_stride) {
        counter.Add(MerlTable::CellCentre(h, d, p), MerlTable::ThetaHWidth(h));
      }
    }
  }
  return counter.Shares();
}

void Score(const Brdf& truth, const Brdf& reconstruction, std::span<const BrdfSample> samples,
           const FrontierConfig& study, FrontierRow* row) {
  const ErrorMetrics m = Compare(truth, reconstruction, study.Metrics());
  row->male = m.male;
  row->log_relative_rms = m.log_relative_rms;
  row->mse = m.mse;
  row->cube_root_rms = m.cube_root_rms;
  row->log_mse = m.log_mse;
  if (const auto* estimate = dynamic_cast<const Estimate*>(&reconstruction)) {
    row->coverage =
        Coverage(truth, *estimate, samples, 4 * study.theta_d_stride, 3 * study.phi_stride);
  }
}

}  // namespace gonio
