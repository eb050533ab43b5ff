// SPDX-License-Identifier: Apache-2.0
// gonio plot: pictures of fits and studies.

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <memory>

#include "apps/gonio/commands.h"
#include "apps/gonio/fit_figures.h"
#include "apps/gonio/locate.h"
#include "apps/gonio/open_any.h"
#include "apps/gonio/study_figures.h"
#include "core/error.h"

namespace gonio {
namespace {

int ChannelOf(const std::string& colour) {
  return static_cast<int>(std::find(std::begin(kChannelNames), std::end(kChannelNames), colour) -
                          std::begin(kChannelNames));
}

std::unique_ptr<Brdf> OpenReference(const PlotOptions& options) {
  if (options.reference.empty()) return nullptr;
  return OpenAny(LocateConfig(options.reference));
}

Plot Draw(const PlotOptions& options) {
  const bool study = IsStudyFolder(options.input);
  const std::string kind = !options.kind.empty() ? options.kind : study ? "density" : "slice";
  if (study != (kind == "density")) {
    throw ConfigError(fmt::format("{}: is {}: there is no {} of it", options.input.string(),
                                  study ? "a study" : "no study", kind));
  }
  if (kind == "density") return DensityPlot(ReadStudy(options.input), options.method);
  const std::unique_ptr<Brdf> reference = OpenReference(options);
  const int channel = ChannelOf(options.colour);
  if (kind == "slice") {
    return LobesPlot(*OpenFit(options.input), reference.get(),
                     {.theta_d = RadFromDeg(options.theta_d_deg),
                      .channel = channel,
                      .keep_every = options.keep_every});
  }
  if (!reference) throw ConfigError("--kind error-map: needs --reference");
  return ErrorMapPlot(*reference, *OpenAny(options.input), channel);
}

}  // namespace

int PlotCommand(const PlotOptions& options) {
  CheckPlotPath(options.out);
  WritePlot(options.out, Draw(options));
  fmt::print("wrote            {}\n", options.out.string());
  return kDone;
}

}  // namespace gonio
