// SPDX-License-Identifier: Apache-2.0
#include "apps/gonio/replay_fit.h"

#include <nlohmann/json.hpp>

#include "apps/gonio/open_any.h"
#include "apps/gonio/summary.h"

namespace gonio {

nlohmann::json Refit(const std::vector<MeasuredPose>& poses, const Prior& prior,
                     const FitOptions& options, const std::filesystem::path& session,
                     const std::filesystem::path& out) {
  std::vector<BrdfSample> samples;
  for (const MeasuredPose& pose : poses) {
    samples.insert(samples.end(), pose.samples.begin(), pose.samples.end());
  }
  const DsbrdfFit fit = FitDsbrdf(samples, prior, options);
  PrintFit(fit, prior);
  const double male = PrintMale(FitOfSession(session), fit, "the session's fit");
  if (!out.empty()) WriteFit(out / kFitFile, fit);
  return {{"male_against_session", male}};
}

}  // namespace gonio
