// SPDX-License-Identifier: Apache-2.0
// Fits a reflectance that is known everywhere (a table, a material) by one of the three methods.

#pragma once

#include <array>
#include <memory>
#include <span>
#include <string>
#include <string_view>
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
  // Of the continuous method. A table is dense and has no noise: finer splines and a loss nearer to
  // the headline metric than in a session serve it better (docs/fitting.md).
  FitOptions continuous = {.floor = 0.1, .huber = 0.5};
  int knots = 12;                // if there is no prior
  const Prior* prior = nullptr;  // null: GenericPrior for `lobes` and `knots`
};

// A channel that could not be fitted, and why.
struct ChannelFailure {
  int channel = 0;
  std::string
      reason;  // "theta_d 45.5 deg: 12 points for 6 parameters, ..."; no material, no colour
};

struct TableFit {
  std::unique_ptr<LobeModel> model;  // null if every channel failed
  std::vector<ChannelFailure> failures;
  // What a user should know of channels that were fitted all the same: slices left out as nothing
  // could be fitted there (the others are interpolated), constant data.
  std::vector<ChannelFailure> warnings;
  int parameters = 0;   // numbers that describe the model
  int unconverged = 0;  // slices, or 1 if the continuous fit did not converge
};

// A channel fails if fewer than half of its slices can be fitted; `WhyNotFittable` (slice_fit.h)
// lists the reasons. Deterministic and single-threaded. Throws ConfigError on options out of range
// only: what is wrong with the data comes back as failures, so that the other channels are not
// lost.
TableFit FitTable(const Brdf& brdf, const TableFitOptions& options);

// The same for scattered samples (a CSV file, a session).
TableFit FitSamples(std::span<const BrdfSample> samples, const TableFitOptions& options);

// The phi_d-averaged points of slices as readings across the half vector's plane (phi_d = 90 deg),
// with the noise of a fair instrument: what the continuous fit of a table starts from. The channels
// that are not asked for, and points where nothing is known, have an infinite sigma.
std::vector<BrdfSample> SamplesOf(std::span<const SliceData> slices,
                                  const std::array<bool, kChannels>& channels);

// Bayes' information criterion (Schwarz, Annals of Statistics 6, 1978) of a model with so many
// parameters, from its residuals in ln(1 + f cos theta_i) at the points of the slices:
// n ln(sum r^2 / n) + parameters ln n. Smaller is better; compare on the same slices only.
double Bic(const LobeModel& model, int parameters, std::span<const SliceData> slices);

// FitTable with each number of lobes from 1 to kMaxLobes; the one that BIC prefers.
// `options.lobes` is ignored. Throws ConfigError if a prior is given: it fixes the lobes.
TableFit FitTableChoosingLobes(const Brdf& brdf, TableFitOptions options);

// A fit file of whichever kind. Reading throws ConfigError.
void WriteFit(const std::filesystem::path& path, const LobeModel& model);
std::unique_ptr<LobeModel> ReadAnyFit(const std::filesystem::path& path);

}  // namespace gonio
