// SPDX-License-Identifier: Apache-2.0
#include "apps/gonio/simulate_session.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <span>
#include <vector>

#include "acquisition/session_costs.h"
#include "apps/gonio/frontier_summary.h"
#include "apps/gonio/summary.h"
#include "brdf/metrics.h"
#include "fitting/fit.h"
#include "fitting/process_fit.h"

namespace gonio {
namespace {

using nlohmann::json;

constexpr int kFirstLook = 4;       // poses after which the true error is looked at first
constexpr double kLookRatio = 1.2;  // then after so many times as many
constexpr MetricOptions kLookMetrics = {.phi_stride = 12, .theta_d_stride = 4};

// Of what the plan's prior makes of the samples.
double MaleOf(std::span<const BrdfSample> samples, const Plan& plan, const Brdf& material,
              const MetricOptions& metrics) {
  if (plan.prior.process) {
    return Compare(material, *FitProcess(samples, plan.prior), metrics).male;
  }
  return Compare(material, FitDsbrdf(samples, plan.prior, plan.fit), metrics).male;
}

// Numbers of poses after which the true error is looked at, ascending.
std::vector<int> Looks(int poses, int stop, bool only_whole) {
  std::vector<int> looks = {poses};
  for (double n = kFirstLook; n < poses && !only_whole; n = std::ceil(n * kLookRatio)) {
    looks.push_back(static_cast<int>(n));
  }
  if (stop > 0) looks.push_back(stop);
  std::sort(looks.begin(), looks.end());
  looks.erase(std::unique(looks.begin(), looks.end()), looks.end());
  return looks;
}

void FindTarget(const SessionSummary& summary, const Plan& plan, const Brdf& material,
                double target, SimulatedSession* session) {
  const std::vector<BrdfSample> samples = summary.Samples();
  const auto clock_at = [&](int poses) { return summary.poses[poses - 1].end; };
  const int stop = PosesToStop(summary, target);
  if (stop > 0) session->by_predicted = {static_cast<double>(stop), clock_at(stop)};
  std::vector<FrontierRow> rows;
  for (const int n : Looks(session->poses, stop, plan.kind == PlannerKind::kGrid)) {
    FrontierRow row;
    row.budget = row.poses = n;
    row.minutes = clock_at(n).count() / 60;
    row.male = MaleOf(std::span(samples).first(n), plan, material, kLookMetrics);
    if (n == stop) session->male_at_stop = row.male;
    rows.push_back(row);
    if (row.male <= target && n >= stop) break;
  }
  const auto crossing = FindCrossing(rows, target);
  if (crossing) session->by_true = {crossing->poses, Seconds(60 * crossing->minutes)};
}

json ToJson(const std::optional<Reached>& reached) {
  if (!reached) return nullptr;
  return {{"poses", reached->poses}, {"duration_s", reached->after.count()}};
}

}  // namespace

SimulatedSession Simulate(const RigFile& rig_file, const NamedPlan& named,
                          const NamedMaterial& material, std::uint64_t seed, double target,
                          const SessionStop& stop) {
  Plan plan = named.plan;
  FitToRig(rig_file.config, plan);
  if (target > 0) plan.information.target_error = 0;
  const std::unique_ptr<Planner> planner =
      MakePlanner(plan, {.reachable = MeasurablePoses(rig_file.config, material.brdf.get()),
                         .costs = CostsOn(rig_file.config),
                         .noise = NoiseOn(rig_file.config),
                         .parts = PartsOn(rig_file.config),
                         .seed = seed});
  OpenedRig rig = OpenSimulated(rig_file, *material.brdf, seed);
  const SessionSummary summary =
      RunSession({rig_file.config, rig.devices, *rig.clock, *planner}, {}, stop);
  SimulatedSession session{.plan = named.name,
                           .material = material.name,
                           .prior = plan.prior.name,
                           .seed = seed,
                           .poses = static_cast<int>(summary.poses.size()),
                           .rejected = summary.rejected,
                           .duration = summary.duration,
                           .predicted_error = summary.predicted_error,
                           .reason = summary.reason,
                           .outcome = summary.outcome};
  if (session.outcome != SessionOutcome::kComplete || summary.poses.empty()) return session;
  session.exposing_per_pose = summary.exposing / static_cast<double>(summary.poses.size());
  session.male = MaleOf(summary.Samples(), plan, *material.brdf, {});
  if (target > 0) FindTarget(summary, plan, *material.brdf, target, &session);
  return session;
}

json ToJson(const SimulatedSession& s, bool with_target) {
  json entry = {{"plan", s.plan},     {"material", s.material},
                {"seed", s.seed},     {"prior", s.prior},
                {"poses", s.poses},   {"rejected", s.rejected},
                {"reason", s.reason}, {"duration_s", s.duration.count()},
                {"male", s.male},     {"exposing_per_pose_s", s.exposing_per_pose.count()}};
  entry["predicted_error"] = s.predicted_error ? json(*s.predicted_error) : json(nullptr);
  if (with_target) {
    entry["reached_predicted"] = ToJson(s.by_predicted);
    entry["reached_true"] = ToJson(s.by_true);
    entry["male_at_stop"] = s.male_at_stop;  // NaN is written as null
  }
  return entry;
}

}  // namespace gonio
