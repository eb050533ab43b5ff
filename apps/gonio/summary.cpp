// SPDX-License-Identifier: Apache-2.0
#include "apps/gonio/summary.h"

#include <fmt/format.h>

#include <algorithm>
#include <thread>

#include "apps/gonio/commands.h"

namespace gonio {

MetricOptions AllCores() {
  MetricOptions options;
  options.threads = static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
  return options;
}

void PrintFit(const DsbrdfFit& fit, const Prior& prior) {
  const FitSummary& s = fit.summary();
  const DsbrdfShape& shape = fit.model().shape();
  fmt::print("fit              {} lobes x {} knots, {} poses, {} readings, prior \"{}\"\n",
             shape.lobes, shape.knots, s.samples, s.residuals, prior.name);
  fmt::print("                 {}: {} after {} steps; model error {:.1f} %\n",
             s.converged ? "converged" : "NOT CONVERGED", s.reason, s.iterations,
             100 * s.model_error);
}

double PrintMale(const Brdf& truth, const Brdf& fit, const std::string& what) {
  const ErrorMetrics metrics = Compare(truth, fit, AllCores());
  fmt::print("MALE             {:.4g} against {}\n", metrics.male, what);
  return metrics.male;
}

void WarnIfSeen(const Prior& prior, const std::string& material) {
  if (!HasSeen(prior, material)) return;
  fmt::print(stderr,
             "gonio: warning: the prior \"{}\" was learned from {}: what follows is too good\n",
             prior.name, material);
}

int PosesToStop(const SessionSummary& summary, double target) {
  const auto within = [&](const std::optional<double>& error) { return error && *error <= target; };
  const auto& poses = summary.poses;
  const auto at = std::find_if(poses.begin(), poses.end(), [&](const SessionPose& pose) {
    return within(pose.predicted_error);
  });
  if (at != poses.end()) return static_cast<int>(at - poses.begin());
  return within(summary.predicted_error) ? static_cast<int>(poses.size()) : 0;
}

int ExitCodeOf(SessionOutcome outcome) {
  switch (outcome) {
    case SessionOutcome::kComplete:
      return kDone;
    case SessionOutcome::kStopped:
      return kStoppedByUser;
    case SessionOutcome::kDeviceFault:
    case SessionOutcome::kEmergencyStop:
      return kDeviceFaultExit;
    case SessionOutcome::kStorageFailed:
      return kFailed;
  }
  return kFailed;
}

}  // namespace gonio
