// SPDX-License-Identifier: Apache-2.0
// gonio simulate: what plans would cost and bring on a rig.

#include <fmt/format.h>

#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "acquisition/session.h"
#include "acquisition/session_costs.h"
#include "acquisition/time_estimate.h"
#include "apps/gonio/build_rig.h"
#include "apps/gonio/commands.h"
#include "apps/gonio/interrupt.h"
#include "apps/gonio/json_file.h"
#include "apps/gonio/locate.h"
#include "apps/gonio/open_any.h"
#include "apps/gonio/progress.h"
#include "apps/gonio/summary.h"
#include "core/error.h"
#include "fitting/fit.h"
#include "fitting/process_fit.h"
#include "planner/plan.h"

namespace gonio {
namespace {

using nlohmann::json;

constexpr double kThinnedShare = 0.3;  // of the theta_h rows: the published decimation

struct NamedPlan {
  std::string name;
  Plan plan;
};

struct Outcome {
  int poses = 0;
  int rejected = 0;
  Seconds duration{0};
  Seconds exposing_per_pose{0};
  double male = std::numeric_limits<double>::quiet_NaN();
  std::optional<double> predicted_error;
  std::string reason;
  SessionOutcome outcome = SessionOutcome::kComplete;
};

// Of what the plan's prior makes of the samples.
double MaleOf(const std::vector<BrdfSample>& samples, const Plan& plan, const Brdf& material) {
  if (plan.prior.process) {
    return Compare(material, *FitProcess(samples, plan.prior), AllCores()).male;
  }
  return Compare(material, FitDsbrdf(samples, plan.prior, plan.fit), AllCores()).male;
}

Outcome RunOne(const SimulateOptions& options, const RigFile& rig_file, const NamedPlan& plan,
               const Brdf& material, std::uint64_t seed, const Interrupt& interrupt) {
  const std::unique_ptr<Planner> planner =
      MakePlanner(plan.plan, {.reachable = MeasurablePoses(rig_file.config, material),
                              .costs = CostsOn(rig_file.config),
                              .seed = seed});
  OpenedRig rig = OpenRig(rig_file, material, seed);
  const bool quiet = options.quiet || options.json == "-";
  ProgressLine line(fmt::format("{} on {}, seed {}", plan.name, material.name(), seed), quiet);
  const SessionSummary summary =
      RunSession({rig_file.config, rig.devices, *rig.clock, *planner}, {},
                 {.after_pose = interrupt.after_pose(), .now = interrupt.now()},
                 [&](const Progress& progress) { line.Show(progress); });
  Outcome outcome{.poses = static_cast<int>(summary.poses.size()),
                  .rejected = summary.rejected,
                  .duration = summary.duration,
                  .predicted_error = summary.predicted_error,
                  .reason = summary.reason,
                  .outcome = summary.outcome};
  if (outcome.outcome != SessionOutcome::kComplete || summary.poses.empty()) return outcome;
  outcome.exposing_per_pose = summary.exposing / static_cast<double>(summary.poses.size());
  outcome.male = MaleOf(summary.Samples(), plan.plan, material);
  return outcome;
}

// Means over the seeds of one plan and material.
Outcome Mean(const std::vector<Outcome>& outcomes) {
  Outcome mean;
  mean.male = 0;
  double poses = 0;
  double predicted = 0;
  int predictions = 0;
  const auto n = static_cast<double>(outcomes.size());
  for (const Outcome& o : outcomes) {
    poses += o.poses / n;
    mean.duration += o.duration / n;
    mean.male += o.male / n;
    predicted += o.predicted_error.value_or(0);
    predictions += o.predicted_error ? 1 : 0;
  }
  mean.poses = static_cast<int>(std::lround(poses));
  if (predictions > 0) mean.predicted_error = predicted / predictions;
  return mean;
}

json ToJson(const NamedPlan& plan, const std::string& material, std::uint64_t seed,
            const Outcome& o) {
  json entry = {{"plan", plan.name},  {"material", material},
                {"seed", seed},       {"prior", plan.plan.prior.name},
                {"poses", o.poses},   {"rejected", o.rejected},
                {"reason", o.reason}, {"duration_s", o.duration.count()},
                {"male", o.male},     {"exposing_per_pose_s", o.exposing_per_pose.count()}};
  entry["predicted_error"] = o.predicted_error ? json(*o.predicted_error) : json(nullptr);
  return entry;
}

json ToJson(const TimeEstimate& estimate) {
  return {{"poses", estimate.poses},
          {"duration_s", estimate.total().count()},
          {"travel_s", estimate.travel.count()},
          {"settling_s", estimate.settling.count()},
          {"exposing_s", estimate.exposing.count()}};
}

double Hours(Seconds duration) { return duration.count() / 3600; }

class Simulation {
 public:
  explicit Simulation(const SimulateOptions& options) : options_(options) {
    rig_ = LoadRig(LocateConfig(options.rig));
    if (!rig_.config.simulated) {
      throw ConfigError(options.rig + ": is not a simulated rig (kind: simulated)");
    }
    for (const std::string& plan : options.plans) {
      const auto path = LocateConfig(plan);
      plans_.push_back({path.stem().string(), LoadPlan(path)});
      if (options.max_poses > 0) plans_.back().plan.max_poses = options.max_poses;
      Prior& prior = plans_.back().plan.prior;
      if (!options.prior.empty()) prior = OpenPrior(options.prior, prior.shape);
    }
    for (const std::string& material : options.materials) {
      materials_.push_back(OpenAny(LocateConfig(material)));
    }
    dense_ = EstimateDenseScan(rig_.config, NominalExposing(rig_.config));
    thinned_ = EstimateDenseScan(rig_.config, NominalExposing(rig_.config), kThinnedShare);
  }

  int Run() {
    const Interrupt interrupt;
    for (const auto& material : materials_) {
      for (const NamedPlan& plan : plans_) {
        const SessionOutcome outcome = RunSeeds(plan, *material, interrupt);
        if (outcome != SessionOutcome::kComplete) return ExitCodeOf(outcome);
      }
    }
    Report();
    return kDone;
  }

 private:
  struct Row {
    std::string plan;
    std::string material;
    Outcome mean;
  };

  // kComplete, or how the first session that did not complete ended.
  SessionOutcome RunSeeds(const NamedPlan& plan, const Brdf& material, const Interrupt& interrupt) {
    std::vector<Outcome> outcomes;
    for (int i = 0; i < options_.seeds; ++i) {
      const std::uint64_t seed = options_.seed + static_cast<std::uint64_t>(i);
      outcomes.push_back(RunOne(options_, rig_, plan, material, seed, interrupt));
      const Outcome& last = outcomes.back();
      if (last.outcome == SessionOutcome::kDeviceFault) {
        fmt::print(stderr, "gonio: {} on {}: {}\n", plan.name, material.name(), last.reason);
      }
      if (last.outcome != SessionOutcome::kComplete) return last.outcome;
      sessions_.push_back(ToJson(plan, material.name(), seed, outcomes.back()));
    }
    rows_.push_back({plan.name, material.name(), Mean(outcomes)});
    return SessionOutcome::kComplete;
  }

  void Report() const {
    if (options_.json != "-") PrintTable();
    if (options_.json.empty()) return;
    WriteJson(options_.json, {{"gonio_version", GONIO_VERSION},
                              {"rig", rig_.config.name},
                              {"sessions", sessions_},
                              {"dense_scan", ToJson(dense_)},
                              {"thinned_scan", ToJson(thinned_)}});
  }

  void PrintTable() const {
    fmt::print("{:<20} {:<20} {:>6} {:>9} {:>9} {:>9} {:>9}\n", "material", "plan", "poses",
               "hours", "of dense", "MALE", "predicted");
    for (const Row& row : rows_) {
      const Outcome& o = row.mean;
      fmt::print("{:<20} {:<20} {:>6} {:>9.3f} {:>7.1f} % {:>9.5f} {:>9}\n", row.material, row.plan,
                 o.poses, Hours(o.duration), 100 * (o.duration / dense_.total()), o.male,
                 o.predicted_error ? fmt::format("{:.5f}", *o.predicted_error) : "-");
    }
    fmt::print("{:<20} {:<20} {:>6} {:>9.3f}\n", "(estimate)", "dense scan", dense_.poses,
               Hours(dense_.total()));
    fmt::print("{:<20} {:<20} {:>6} {:>9.3f} {:>7.1f} %\n", "(estimate)", "30 % of its rows",
               thinned_.poses, Hours(thinned_.total()), 100 * (thinned_.total() / dense_.total()));
    if (options_.seeds > 1) {
      fmt::print("means over seeds {} to {}\n", options_.seed,
                 options_.seed + static_cast<std::uint64_t>(options_.seeds) - 1);
    }
  }

  const SimulateOptions& options_;
  RigFile rig_;
  std::vector<NamedPlan> plans_;
  std::vector<std::unique_ptr<Brdf>> materials_;
  TimeEstimate dense_;
  TimeEstimate thinned_;
  std::vector<Row> rows_;
  json sessions_ = json::array();
};

}  // namespace

int SimulateCommand(const SimulateOptions& options) { return Simulation(options).Run(); }

}  // namespace gonio
