// SPDX-License-Identifier: Apache-2.0
// gonio fit: a table, samples or a session, fitted again.

#include "fitting/fit.h"

#include <fmt/format.h>

#include <optional>

#include "acquisition/session_record.h"
#include "apps/gonio/commands.h"
#include "apps/gonio/open_any.h"
#include "apps/gonio/summary.h"
#include "brdf/merl_table.h"
#include "brdf/metrics.h"
#include "brdf/samples_csv.h"
#include "core/error.h"
#include "planner/candidates.h"
#include "planner/plan.h"

namespace gonio {
namespace {

struct Input {
  std::vector<BrdfSample> samples;
  std::optional<MerlTable> table;  // the truth, if the input is one
};

// One sample for each (theta_h, theta_d) of the raster a session chooses from, with the noise of a
// fair instrument.
std::vector<BrdfSample> DenseSamples(const MerlTable& table) {
  std::vector<BrdfSample> samples;
  for (const Candidate& candidate : MakeCandidates({}, {})) {
    const std::optional<Rgb> f_r = table.Eval(candidate.angles);
    if (!f_r) continue;
    const Rgb sigma = kDefaultRelativeSigma * f_r->abs() + kDefaultSigmaFloor;
    samples.push_back({candidate.directions, *f_r, sigma});
  }
  return samples;
}

Input ReadInput(const std::filesystem::path& path) {
  if (std::filesystem::is_directory(path)) return {ReadSession(path).Samples(), {}};
  const std::string extension = path.extension().string();
  if (extension == ".csv") {
    Input input;
    for (const MeasuredSample& row : ReadSamplesCsv(path)) input.samples.push_back(row.sample);
    return input;
  }
  if (extension == ".binary") {
    MerlTable table = MerlTable::Open(path);
    std::vector<BrdfSample> samples = DenseSamples(table);
    return {std::move(samples), std::move(table)};
  }
  throw ConfigError(path.string() + ": can fit a .binary, a .csv or a session directory only");
}

}  // namespace

int FitCommand(const FitCommandOptions& options) {
  DsbrdfShape shape;
  const int lobes = options.lobes.empty() ? 0 : std::stoi(options.lobes);
  if (lobes != 0) shape.lobes = lobes;
  const Prior prior = OpenPrior(options.prior, shape);
  if (lobes != 0 && prior.shape.lobes != lobes) {
    throw ConfigError(fmt::format("{}: is a prior for {} lobes, not {}", options.prior,
                                  prior.shape.lobes, lobes));
  }
  const Input input = ReadInput(options.input);
  if (input.samples.empty()) {
    throw ConfigError(options.input.string() + ": holds no sample to fit");
  }
  const DsbrdfFit fit = FitDsbrdf(input.samples, prior);
  WriteFit(options.out, fit);
  PrintFit(fit, prior);
  if (input.table) PrintMale(*input.table, fit, "the table");
  fmt::print("wrote            {}\n", options.out.string());
  return kDone;
}

}  // namespace gonio
