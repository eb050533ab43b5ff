// SPDX-License-Identifier: Apache-2.0
#include "fitting/sliced_dsbrdf.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/error.h"
#include "core/units.h"
#include "fitting/hemi_epd.h"

namespace gonio {
namespace {

// What kappa and gamma are interpolated through. The published method splines them as they are; the
// joint fit splines what it iterates.
double Transformed(SliceMethod method, double x) {
  return method == SliceMethod::kJoint ? std::log(std::max(x, 1e-300)) : x;
}
double Restored(SliceMethod method, double y) {
  return method == SliceMethod::kJoint ? std::exp(y) : std::max(y, 1e-6);
}

}  // namespace

std::string_view NameOf(SliceMethod method) { return method == SliceMethod::kEm ? "em" : "joint"; }

SlicedDsbrdf::SlicedDsbrdf(SliceMethod method,
                           std::array<std::vector<FittedSlice>, kChannels> slices,
                           std::vector<SliceReport> reports, std::string name)
    : method_(method),
      slices_(std::move(slices)),
      reports_(std::move(reports)),
      name_(std::move(name)) {
  for (int c = 0; c < kChannels; ++c) {
    for (const FittedSlice& slice : slices_[c]) {
      const int count = static_cast<int>(slice.lobes.size());
      if (lobes_ == 0) lobes_ = count;
      GONIO_CHECK(count == lobes_ && count > 0, "as many lobes in every slice");
    }
    BuildCurves(c);
  }
  if (lobes_ == 0) throw ConfigError(name_ + ": no colour has a slice");
}

void SlicedDsbrdf::BuildCurves(int channel) {
  const std::vector<FittedSlice>& slices = slices_[channel];
  std::vector<double> theta_d;
  for (const FittedSlice& slice : slices) theta_d.push_back(slice.theta_d);
  const auto curve = [&](int k, double Lobe::*quantity) {
    std::vector<double> values;
    for (const FittedSlice& slice : slices) {
      values.push_back(Transformed(method_, slice.lobes[k].*quantity));
    }
    return InterpolatingSpline(
        theta_d, values,
        method_ == SliceMethod::kJoint ? SplineKind::kMonotone : SplineKind::kNatural);
  };
  if (slices.empty()) return;
  for (int k = 0; k < lobes_; ++k) {
    kappa_[channel].push_back(curve(k, &Lobe::kappa));
    gamma_[channel].push_back(curve(k, &Lobe::gamma));
  }
}

std::vector<Lobe> SlicedDsbrdf::LobesAt(double theta_d, int channel) const {
  std::vector<Lobe> lobes;
  for (std::size_t k = 0; k < kappa_[channel].size(); ++k) {
    lobes.push_back({Restored(method_, kappa_[channel][k](theta_d)),
                     Restored(method_, gamma_[channel][k](theta_d))});
  }
  return lobes;
}

std::optional<Rgb> SlicedDsbrdf::Eval(const HalfDiff& angles) const {
  double cos_i = 0;
  double cos_o = 0;
  Cosines(angles, &cos_i, &cos_o);
  if (!(cos_i > 0 && cos_o > 0)) return std::nullopt;
  const double log_cos = LogCos(angles.theta_h);
  Rgb f_r = Rgb::Constant(std::numeric_limits<double>::quiet_NaN());
  for (int c = 0; c < kChannels; ++c) {
    if (kappa_[c].empty()) continue;
    f_r[c] = 0;
    for (std::size_t k = 0; k < kappa_[c].size(); ++k) {
      const Lobe lobe = {Restored(method_, kappa_[c][k](angles.theta_d)),
                         Restored(method_, gamma_[c][k](angles.theta_d))};
      f_r[c] += EvalLobe(lobe, log_cos);
    }
  }
  return f_r;
}

int SlicedDsbrdf::parameter_count() const {
  std::size_t slices = 0;
  for (const auto& channel : slices_) slices += channel.size();
  return static_cast<int>(2 * slices * lobes_);
}

}  // namespace gonio
