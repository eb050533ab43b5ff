// SPDX-License-Identifier: Apache-2.0
#include "apps/gonio/open_any.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <sstream>

#include "brdf/open.h"
#include "core/config.h"
#include "core/error.h"
#include "core/sha256.h"
#include "fitting/process_file.h"
#include "fitting/process_fit.h"
#include "fitting/table_fit.h"
#include "planner/plan.h"

namespace gonio {
namespace {

bool IsYaml(const std::filesystem::path& path) {
  std::string extension = path.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return std::tolower(c); });
  return extension == ".yaml" || extension == ".yml";
}

}  // namespace

bool IsFitFile(const std::filesystem::path& path) {
  if (!IsYaml(path)) return false;
  try {
    return ConfigNode::Load(path).Has("format");
  } catch (const ConfigError&) {
    return false;  // whoever opens it for real says what is wrong
  }
}

std::unique_ptr<Brdf> OpenAny(const std::filesystem::path& path) {
  if (std::filesystem::is_directory(path)) return EstimateOfSession(path);
  if (IsFitFile(path)) return OpenFit(path);
  return OpenBrdf(path);
}

std::unique_ptr<LobeModel> OpenFit(const std::filesystem::path& path) {
  if (std::filesystem::is_directory(path)) return std::make_unique<DsbrdfFit>(FitOfSession(path));
  if (IsFitFile(path)) return ReadAnyFit(path);
  throw ConfigError(path.string() + ": is neither a fit file nor a session directory");
}

std::unique_ptr<Brdf> EstimateOfSession(const std::filesystem::path& dir) {
  const SessionRecord session = ReadSession(dir);
  if (!session.poses.empty()) {
    const Prior prior = PriorOfSession(LatestInfo(session));
    if (prior.process) return FitProcess(session.Samples(), prior);
  }
  return OpenFit(dir);
}

DsbrdfFit FitOfSession(const std::filesystem::path& dir) {
  const SessionRecord session = ReadSession(dir);
  if (std::filesystem::exists(dir / kFitFile)) return ReadFit(dir / kFitFile);
  if (session.poses.empty()) throw ConfigError(dir.string() + ": holds no measured pose to fit");
  const SessionInfo info = LatestInfo(session);
  const Plan plan = ParsePlan(info.plan_text, info.plan_path);
  return FitDsbrdf(session.Samples(), PriorOfSession(info), plan.fit);
}

Prior PriorOfSession(const SessionInfo& info) {
  Plan plan = ParsePlan(info.plan_text, info.plan_path);
  if (!info.prior_spec.empty()) plan.Believe(OpenPrior(info.prior_spec, plan.prior.shape));
  if (HashOf(plan.prior) != info.prior_sha256) {
    throw ConfigError(
        fmt::format("prior \"{}\" is no longer the one that the session was run with; "
                    "fit its samples with another by gonio fit --prior",
                    info.prior_name));
  }
  return plan.prior;
}

std::string HashOf(const Prior& prior) {
  std::string text = fmt::format("{} {}", prior.shape.lobes, prior.shape.knots);
  for (const double number : prior.mean) text += fmt::format(" {:.9e}", number);
  for (const double number : prior.covariance.reshaped()) text += fmt::format(" {:.9e}", number);
  if (prior.process) {
    std::ostringstream process;
    WriteProcess(process, *prior.process);
    text += process.str();
  }
  return Sha256(text);
}

}  // namespace gonio
