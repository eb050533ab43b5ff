// SPDX-License-Identifier: Apache-2.0
// Fits a reflectance that is known everywhere (a table, a material) by one of the three methods.

#pragma once

#include <array>
#include <memory>
#include <string>
#include <vector>

#include "fitting/fit.h"
#include "fitting/prior.h"
#include "fitting/slice_data.h"
#include "fitting/sliced_dsbrdf.h"

namespace gonio {

enum class FitMethod { kEm, kJoint, kContinuous };
std::string_view NameOf(FitMethod method);  // "em", "joint", "continuous"
// Throws ConfigError on any other name.
FitMethod FitMethodFromName(std::string_view name);

struct TableFitOptions {
  FitMethod method = FitMethod::kContinuous;
  int lobes = 3;        // 1 .. kMaxLobes
  SliceOptions slices;  // the continuous method uses a step of one cell, whatever it says
  std::array<bool, kChannels> channels = {true, true, true};  // which colours to fit
  // Of the continuous method; null: GenericPrior for `lobes`.
  const Prior* prior = nullptr;
  FitOptions continuous;
};

// A channel that could not be fitted.
struct ChannelFailure {
  int channel = 0;
  std::string
      reason;  // "theta_d 45.5 deg: 12 points for 6 parameters, ..."; no material, no colour
};

struct TableFit {
  std::unique_ptr<LobeModel> model;  // null if every channel failed
  std::vector<ChannelFailure> failures;
  int parameters = 0;   // numbers that describe the model
  int unconverged = 0;  // slices, or 1 if the continuous fit did not converge
};

// Deterministic and single-threaded. Throws ConfigError on options out of range only: what is wrong
// with the data comes back as failures, so that the other channels are not lost.
TableFit FitTable(const Brdf& brdf, const TableFitOptions& options);

// The same for scattered samples (a CSV file, a session).
TableFit FitSamples(std::span<const BrdfSample> samples, const TableFitOptions& options);

}  // namespace gonio
