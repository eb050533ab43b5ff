// SPDX-License-Identifier: Apache-2.0
#include "fitting/slice_data.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "brdf/merl_table.h"
#include "core/check.h"
#include "core/error.h"

namespace gonio {
namespace {

// The cell whose centre is nearest to n steps above that of the first.
int SliceCell(int n, double step) {
  return static_cast<int>(std::lround(n * step / (kPi / 2 / MerlTable::kThetaD)));
}

// Means over phi_d at one theta_h; a channel that is not finite there is left out of its own mean.
void Average(const Brdf& brdf, int h, int d, int phi_stride, SlicePoint (&points)[kChannels]) {
  for (int p = 0; p < MerlTable::kPhiD; p += phi_stride) {
    const HalfDiff angles = MerlTable::CellCentre(h, d, p);
    double cos_i = 0;
    double cos_o = 0;
    Cosines(angles, &cos_i, &cos_o);
    if (!(cos_i > 0 && cos_o > 0)) continue;
    const std::optional<Rgb> f_r = brdf.Eval(angles);
    if (!f_r) continue;
    for (int c = 0; c < kChannels; ++c) {
      if (!std::isfinite((*f_r)[c])) continue;
      points[c].f_r += (*f_r)[c];
      points[c].cos_theta_i += cos_i;
      ++points[c].cells;
    }
  }
  for (SlicePoint& point : points) {
    if (point.cells == 0) continue;
    point.f_r /= point.cells;
    point.cos_theta_i /= point.cells;
  }
}

}  // namespace

void SliceOptions::Check() const {
  if (!(step >= RadFromDeg(1) * (1 - 1e-9) && step <= RadFromDeg(30) * (1 + 1e-9))) {
    throw ConfigError(
        fmt::format("slice_step_deg: is {}, must be between 1 and 30", DegFromRad(step)));
  }
  if (keep_every < 1 || keep_every > MerlTable::kThetaH) {
    throw ConfigError(
        fmt::format("keep_every: is {}, must be between 1 and {}", keep_every, MerlTable::kThetaH));
  }
  if (phi_stride < 1 || phi_stride > MerlTable::kPhiD) {
    throw ConfigError(
        fmt::format("phi_stride: is {}, must be between 1 and {}", phi_stride, MerlTable::kPhiD));
  }
}

SliceData SliceAt(const Brdf& brdf, int theta_d_cell, const SliceOptions& options) {
  GONIO_CHECK(theta_d_cell >= 0 && theta_d_cell < MerlTable::kThetaD, "theta_d of the table");
  SliceData slice;
  slice.theta_d = MerlTable::CellCentre(0, theta_d_cell, 0).theta_d;
  for (int h = 0; h < MerlTable::kThetaH; h += options.keep_every) {
    SlicePoint points[kChannels];
    Average(brdf, h, theta_d_cell, options.phi_stride, points);
    for (int c = 0; c < kChannels; ++c) {
      points[c].theta_h = MerlTable::CellCentre(h, theta_d_cell, 0).theta_h;
      points[c].width = MerlTable::ThetaHWidth(h);
      slice.points[c].push_back(points[c]);
    }
  }
  return slice;
}

std::vector<SliceData> SlicesOf(const Brdf& brdf, const SliceOptions& options) {
  options.Check();
  std::vector<SliceData> slices;
  for (int n = 0; SliceCell(n, options.step) < MerlTable::kThetaD; ++n) {
    slices.push_back(SliceAt(brdf, SliceCell(n, options.step), options));
  }
  return slices;
}

std::vector<SliceData> SlicesOf(std::span<const BrdfSample> samples, const SliceOptions& options) {
  options.Check();
  if (options.keep_every != 1) {
    throw ConfigError("keep_every: thins the theta_h of a table; these are scattered samples");
  }
  // Slice -> its samples' angles, by theta_h.
  std::map<int, std::vector<std::pair<HalfDiff, const BrdfSample*>>> bins;
  for (const BrdfSample& sample : samples) {
    const HalfDiff angles = ToHalfDiff(sample.directions);
    bins[static_cast<int>(std::lround(angles.theta_d / options.step))].emplace_back(angles,
                                                                                    &sample);
  }
  std::vector<SliceData> slices;
  for (auto& [n, bin] : bins) {
    std::stable_sort(bin.begin(), bin.end(), [](const auto& a, const auto& b) {
      return a.first.theta_h < b.first.theta_h;
    });
    SliceData slice;
    slice.theta_d = std::min(n * options.step, kPi / 2);
    for (const auto& [angles, sample] : bin) {
      for (int c = 0; c < kChannels; ++c) {
        const bool usable = std::isfinite(sample->sigma[c]);
        slice.points[c].push_back({.theta_h = angles.theta_h,
                                   .width = 0,
                                   .f_r = usable ? sample->f_r[c] : 0,
                                   .cos_theta_i = usable ? sample->directions.cos_theta_i() : 0,
                                   .cells = usable ? 1 : 0});
      }
    }
    slices.push_back(std::move(slice));
  }
  return slices;
}

}  // namespace gonio
