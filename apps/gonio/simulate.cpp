// SPDX-License-Identifier: Apache-2.0
// gonio simulate: what plans would cost and bring on a rig.

#include <fmt/format.h>

#include <cmath>
#include <limits>
#include <mutex>
#include <nlohmann/json.hpp>
#include <span>

#include "acquisition/time_estimate.h"
#include "apps/gonio/commands.h"
#include "apps/gonio/interrupt.h"
#include "apps/gonio/json_file.h"
#include "apps/gonio/locate.h"
#include "apps/gonio/progress.h"
#include "apps/gonio/simulate_answer.h"
#include "apps/gonio/simulate_materials.h"
#include "apps/gonio/simulate_session.h"
#include "apps/gonio/statistics.h"
#include "apps/gonio/summary.h"
#include "core/error.h"
#include "core/task_pool.h"

namespace gonio {
namespace {

using nlohmann::json;

constexpr double kThinnedShare = 0.3;  // of the theta_h rows: the published decimation

json ToJson(const TimeEstimate& estimate) {
  return {{"poses", estimate.poses},
          {"duration_s", estimate.total().count()},
          {"travel_s", estimate.travel.count()},
          {"settling_s", estimate.settling.count()},
          {"exposing_s", estimate.exposing.count()}};
}

double Hours(Seconds duration) { return duration.count() / 3600; }

std::vector<NamedPlan> LoadPlans(const SimulateOptions& options) {
  std::vector<NamedPlan> plans;
  for (const std::string& name : options.plans) {
    const auto path = LocateConfig(name);
    for (const NamedPlan& other : plans) {
      if (other.name == path.stem()) {
        throw ConfigError(fmt::format("--plan: there are two called \"{}\"", other.name));
      }
    }
    plans.push_back({path.stem().string(), LoadPlan(path)});
    Plan& plan = plans.back().plan;
    if (options.max_poses > 0) plan.max_poses = options.max_poses;
    if (!options.prior.empty()) plan.Believe(OpenPrior(options.prior, plan.prior.shape));
  }
  return plans;
}

class Simulation {
 public:
  explicit Simulation(const SimulateOptions& options)
      : options_(options), rig_(LoadRig(LocateConfig(options.rig))) {
    plans_ = LoadPlans(options);
    materials_ = options.materials.empty() ? DrawMaterials(options.draws, options.seed, plans_)
                                           : OpenMaterials(options.materials, plans_);
    dense_ = EstimateDenseScan(rig_.config, NominalExposing(rig_.config));
    thinned_ = EstimateDenseScan(rig_.config, NominalExposing(rig_.config), kThinnedShare);
    sessions_.resize(materials_.size() * plans_.size() * static_cast<std::size_t>(options.seeds));
  }

  int Run() {
    Measure();
    for (const SimulatedSession& session : sessions_) {
      if (session.outcome == SessionOutcome::kDeviceFault) {
        fmt::print(stderr, "gonio: {} on {}: {}\n", session.plan, session.material, session.reason);
      }
      if (session.outcome != SessionOutcome::kComplete) return ExitCodeOf(session.outcome);
    }
    if (options_.json != "-") Print();
    if (!options_.json.empty()) Write();
    return kDone;
  }

 private:
  // Sessions are sorted by material, then plan, then seed.
  void Measure() {
    const Interrupt interrupt;
    const SessionStop stop{.after_pose = interrupt.after_pose(), .now = interrupt.now()};
    ProgressLine line("simulating", options_.quiet || options_.json == "-");
    std::mutex mutex;
    int finished = 0;
    const auto seeds = static_cast<std::size_t>(options_.seeds);
    ForEachTask(sessions_.size(), ThreadsOr(options_.threads), stop.after_pose, [&](std::size_t i) {
      const NamedMaterial& material = materials_[i / seeds / plans_.size()];
      const NamedPlan& plan = plans_[i / seeds % plans_.size()];
      sessions_[i] =
          Simulate(rig_, plan, material, options_.seed + i % seeds, options_.target, stop);
      const std::lock_guard lock(mutex);
      ++finished;
      const int total = static_cast<int>(sessions_.size());
      line.Show(finished, total, fmt::format("{} of {} sessions", finished, total));
    });
  }

  void Print() const {
    if (materials_.front().drawn) {
      fmt::print("No material was named: {} drawn from the prior \"{}\", which plans know, too.\n",
                 materials_.size(), SourceOfDraws(plans_).name);
    }
    fmt::print("{:<20} {:<20} {:>6} {:>9} {:>9} {:>9} {:>9}\n", "material", "plan", "poses",
               "hours", "of dense", "MALE", "predicted");
    const auto seeds = static_cast<std::size_t>(options_.seeds);
    for (std::size_t i = 0; i < sessions_.size(); i += seeds) {
      PrintMeans({sessions_.begin() + static_cast<std::ptrdiff_t>(i),
                  sessions_.begin() + static_cast<std::ptrdiff_t>(i + seeds)});
    }
    fmt::print("{:<20} {:<20} {:>6} {:>9.3f}\n", "(estimate)", "dense scan", dense_.poses,
               Hours(dense_.total()));
    fmt::print("{:<20} {:<20} {:>6} {:>9.3f} {:>7.1f} %\n", "(estimate)", "30 % of its rows",
               thinned_.poses, Hours(thinned_.total()), 100 * (thinned_.total() / dense_.total()));
    if (options_.seeds > 1) {
      fmt::print("means over seeds {} to {}\n", options_.seed,
                 options_.seed + static_cast<std::uint64_t>(options_.seeds) - 1);
    }
    if (options_.target > 0) {
      PrintAnswers(AnswersOf(sessions_), options_.target,
                   {Hours(dense_.total()), Hours(thinned_.total())});
    }
  }

  // Over the seeds of one plan and material.
  void PrintMeans(std::span<const SimulatedSession> sessions) const {
    const auto mean = [&](auto number) {
      std::vector<double> numbers;
      for (const SimulatedSession& session : sessions) numbers.push_back(number(session));
      return MeanOf(numbers);
    };
    const double poses = mean([](const SimulatedSession& s) { return s.poses; });
    const double hours = mean([](const SimulatedSession& s) { return Hours(s.duration); });
    const double male = mean([](const SimulatedSession& s) { return s.male; });
    const double predicted = mean([](const SimulatedSession& s) {
      return s.predicted_error.value_or(std::numeric_limits<double>::quiet_NaN());
    });
    fmt::print("{:<20} {:<20} {:>6.0f} {:>9.3f} {:>7.1f} % {:>9.5f} {:>9}\n",
               sessions.front().material, sessions.front().plan, poses, hours,
               100 * hours / Hours(dense_.total()), male,
               std::isnan(predicted) ? "-" : fmt::format("{:.5f}", predicted));
  }

  void Write() const {
    json sessions = json::array();
    for (const SimulatedSession& session : sessions_) {
      sessions.push_back(ToJson(session, options_.target > 0));
    }
    json all = {{"gonio_version", GONIO_VERSION},
                {"rig", rig_.config.name},
                {"sessions", sessions},
                {"dense_scan", ToJson(dense_)},
                {"thinned_scan", ToJson(thinned_)}};
    if (materials_.front().drawn) all["materials_drawn_from"] = SourceOfDraws(plans_).name;
    if (options_.target > 0) {
      all["target"] = options_.target;
      for (const Answer& answer : AnswersOf(sessions_)) all["answers"].push_back(ToJson(answer));
    }
    WriteJson(options_.json, all);
  }

  const SimulateOptions& options_;
  RigFile rig_;
  std::vector<NamedPlan> plans_;
  std::vector<NamedMaterial> materials_;
  TimeEstimate dense_;
  TimeEstimate thinned_;
  std::vector<SimulatedSession> sessions_;
};

}  // namespace

int SimulateCommand(const SimulateOptions& options) { return Simulation(options).Run(); }

}  // namespace gonio
