// SPDX-License-Identifier: Apache-2.0
// The DSBRDF as published: lobes fitted slice by slice, interpolated over theta_d.

#pragma once

#include <array>
#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "fitting/interpolating_spline.h"
#include "fitting/lobe_model.h"

namespace gonio {

// How a slice was fitted.
enum class SliceMethod {
  kEm,     // Algorithm 1 of Edahiro et al. (fitting/slice_em.h)
  kJoint,  // all lobes of a slice together (fitting/slice_joint.h)
};
std::string_view NameOf(SliceMethod method);  // "em", "joint"

// How the fit of one slice and channel went; the numbers that did not work out are data.
struct SliceReport {
  double theta_d = 0;  // rad
  int channel = 0;
  int points = 0;      // theta_h with a value
  int iterations = 0;  // of EM, or of Levenberg-Marquardt
  bool converged = false;
  double cost = 0;     // what was minimised (the method's header says)
  std::string reason;  // why the iteration ended, or why the slice could not be fitted
};

// Lobes of one channel at one theta_d.
struct FittedSlice {
  double theta_d = 0;  // rad
  std::vector<Lobe> lobes;
};

// kappa and gamma of each lobe interpolated over theta_d between fitted slices, held constant
// beyond the first and the last.
class SlicedDsbrdf final : public LobeModel {
 public:
  // Slices of a channel in ascending theta_d, all with the same number of lobes, lobe k of each
  // being the continuation of lobe k of the one before. A channel without slices is unknown: Eval
  // gives NaN there, LobesAt nothing. Throws ConfigError if no channel has a slice.
  SlicedDsbrdf(SliceMethod method, std::array<std::vector<FittedSlice>, kChannels> slices,
               std::vector<SliceReport> reports, std::string name = "DSBRDF");

  using Brdf::Eval;
  std::optional<Rgb> Eval(const HalfDiff& angles) const override;
  std::string name() const override { return name_; }
  int lobes() const override { return lobes_; }
  std::vector<Lobe> LobesAt(double theta_d, int channel) const override;

  SliceMethod method() const { return method_; }
  const std::vector<FittedSlice>& slices(int channel) const { return slices_[channel]; }
  // One for each slice and channel that was tried, failed ones included.
  const std::vector<SliceReport>& reports() const { return reports_; }
  // How many numbers describe it: 2 x lobes x slices x channels.
  int parameter_count() const;

 private:
  void BuildCurves(int channel);

  SliceMethod method_;
  std::array<std::vector<FittedSlice>, kChannels> slices_;
  std::vector<SliceReport> reports_;
  std::string name_;
  int lobes_ = 0;
  std::array<std::vector<InterpolatingSpline>, kChannels> kappa_, gamma_;  // one for each lobe
};

// A fit file (docs/data-format.md), written atomically.
void WriteFit(const std::filesystem::path& path, const SlicedDsbrdf& fit);

}  // namespace gonio
