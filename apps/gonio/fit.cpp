// SPDX-License-Identifier: Apache-2.0
// gonio fit: a table, a material, samples or a session, fitted by one of three methods.

#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <variant>

#include "acquisition/session_record.h"
#include "apps/gonio/commands.h"
#include "apps/gonio/open_any.h"
#include "apps/gonio/summary.h"
#include "brdf/merl_table.h"
#include "brdf/open.h"
#include "brdf/sample_metrics.h"
#include "brdf/samples_csv.h"
#include "core/error.h"
#include "fitting/table_fit.h"
#include "planner/plan.h"

namespace gonio {
namespace {

// What is known everywhere, or scattered samples.
using Input = std::variant<std::unique_ptr<Brdf>, std::vector<BrdfSample>>;

Input ReadInput(const std::filesystem::path& path) {
  if (std::filesystem::is_directory(path)) return ReadSession(path).Samples();
  if (path.extension() == ".csv") {
    std::vector<BrdfSample> samples;
    for (const MeasuredSample& row : ReadSamplesCsv(path)) samples.push_back(row.sample);
    return samples;
  }
  if (IsFitFile(path)) throw ConfigError(path.string() + ": is a fit already");
  return OpenBrdf(path);
}

TableFit Fit(const Input& input, const FitCommandOptions& options, const Prior& prior,
             TableFitOptions fit_options) {
  const auto* samples = std::get_if<std::vector<BrdfSample>>(&input);
  if (samples != nullptr && samples->empty()) {
    throw ConfigError(options.input.string() + ": holds no sample to fit");
  }
  if (samples != nullptr) {
    if (options.lobes == "auto") {
      throw ConfigError("--lobes auto: needs a table, not scattered samples");
    }
    fit_options.continuous = {};  // readings are noisy: as in a session
    fit_options.prior = &prior;
    return FitSamples(*samples, fit_options);
  }
  const Brdf& brdf = *std::get<std::unique_ptr<Brdf>>(input);
  return options.lobes == "auto" ? FitTableChoosingLobes(brdf, fit_options)
                                 : FitTable(brdf, fit_options);
}

void PrintSlices(const SlicedDsbrdf& fit) {
  const auto& reports = fit.reports();
  int iterations = 0;
  int most = 0;
  int points = 0;
  for (const SliceReport& report : reports) {
    iterations += report.iterations;
    most = std::max(most, report.iterations);
    points += report.points;
  }
  fmt::print("fit              {}, {} lobes, {} slices, {} points\n", NameOf(fit.method()),
             fit.lobes(), reports.size(), points);
  const auto unfinished = std::count_if(reports.begin(), reports.end(),
                                        [](const SliceReport& r) { return !r.converged; });
  fmt::print("                 {} of {} slices converged; {} iterations, at most {} in a slice\n",
             reports.size() - unfinished, reports.size(), iterations, most);
  constexpr int kShown = 3;
  int shown = 0;
  for (const SliceReport& report : reports) {
    if (report.converged || shown++ >= kShown) continue;
    fmt::print("                 theta_d {:.1f} deg, {}: {}\n", DegFromRad(report.theta_d),
               kChannelNames[report.channel], report.reason);
  }
  if (shown > kShown) {
    fmt::print("                 and {} more; the fit file lists every slice\n", shown - kShown);
  }
}

void PrintResiduals(const std::vector<BrdfSample>& samples, const Brdf& fit) {
  const SampleMetrics m = CompareSamples(samples, fit);
  if (m.readings == 0) return;
  fmt::print("MALE             {:.4g} at its own samples; they are off by {:.1f} sigma rms\n",
             m.male, m.z_rms);
}

void PrintSize(int parameters) {
  constexpr int kTableNumbers = kChannels * MerlTable::kCells;
  fmt::print("size             {} numbers for a table of {}: {:.0f} times smaller\n", parameters,
             kTableNumbers, static_cast<double>(kTableNumbers) / parameters);
}

void Complain(const std::filesystem::path& input, const std::vector<ChannelFailure>& complaints,
              const char* severity) {
  for (const ChannelFailure& complaint : complaints) {
    fmt::print(stderr, "gonio: {}{}, {}: {}\n", severity, input.stem().string(),
               kChannelNames[complaint.channel], complaint.reason);
  }
}

}  // namespace

int FitCommand(const FitCommandOptions& options) {
  TableFitOptions fit_options;
  fit_options.method = FitMethodFromName(options.method);
  fit_options.slices.step = RadFromDeg(options.slice_step_deg);
  fit_options.slices.keep_every = options.keep_every;
  const bool counted = !options.lobes.empty() && options.lobes != "auto";
  if (counted) fit_options.lobes = std::stoi(options.lobes);
  const Prior prior = OpenPrior(options.prior, {.lobes = fit_options.lobes});
  if (!counted) fit_options.lobes = prior.shape.lobes;
  if (options.prior != "generic") fit_options.prior = &prior;

  const Input input = ReadInput(options.input);
  const TableFit fit = Fit(input, options, prior, fit_options);
  Complain(options.input, fit.warnings, "warning: ");
  Complain(options.input, fit.failures, "");
  if (!fit.model) throw ConfigError(options.input.string() + ": no colour could be fitted");
  WriteFit(options.out, *fit.model);
  if (const auto* sliced = dynamic_cast<const SlicedDsbrdf*>(fit.model.get())) {
    PrintSlices(*sliced);
  } else {
    PrintFit(dynamic_cast<const DsbrdfFit&>(*fit.model), prior);
  }
  PrintSize(fit.parameters);
  if (const auto* brdf = std::get_if<std::unique_ptr<Brdf>>(&input)) {
    PrintMale(**brdf, *fit.model, "the input");
  } else {
    PrintResiduals(std::get<std::vector<BrdfSample>>(input), *fit.model);
  }
  fmt::print("wrote            {}\n", options.out.string());
  return fit.failures.empty() ? kDone : kFailed;
}

}  // namespace gonio
