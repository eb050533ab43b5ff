// SPDX-License-Identifier: Apache-2.0
// gonio prior learn: a prior from materials.

#include <fmt/format.h>

#include <algorithm>
#include <memory>
#include <thread>
#include <vector>

#include "apps/gonio/commands.h"
#include "apps/gonio/locate.h"
#include "apps/gonio/open_any.h"
#include "core/error.h"
#include "planner/prior_calibration.h"

namespace gonio {

int PriorLearnCommand(const PriorLearnOptions& options) {
  if (std::filesystem::exists(options.out)) {
    throw ConfigError(options.out.string() + ": exists already; name another file");
  }
  std::vector<std::unique_ptr<Brdf>> brdfs;
  std::vector<TrainingMaterial> materials;
  for (const std::string& name : options.materials) {
    const std::filesystem::path path = LocateConfig(name);
    brdfs.push_back(OpenAny(path));
    materials.push_back({path.stem().string(), brdfs.back().get()});
  }
  LearnOptions learn;
  learn.name = options.out.stem().string();
  learn.threads = static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
  const Prior prior = LearnCalibratedPrior(materials, learn);
  WritePrior(options.out, prior);
  fmt::print("materials        {}\n", materials.size());
  fmt::print("components       {} of luminance, {} of chroma\n", prior.process->luminance.cols(),
             prior.process->chroma.cols());
  fmt::print("error margin     {:.2f}\n", prior.process->error_margin);
  for (const Calibration& at : prior.process->calibration) {
    fmt::print("interval {:3.0f} %   {:.2f} times a Gaussian's\n", 100 * at.probability,
               at.widening);
  }
  fmt::print("wrote            {}\n", options.out.string());
  return kDone;
}

}  // namespace gonio
