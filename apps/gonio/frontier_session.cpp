// SPDX-License-Identifier: Apache-2.0
#include "apps/gonio/frontier_session.h"

#include <fmt/format.h>

#include <algorithm>
#include <ctime>
#include <map>
#include <span>

#include "acquisition/session.h"
#include "acquisition/session_costs.h"
#include "apps/gonio/frontier_reconstruction.h"
#include "apps/gonio/frontier_score.h"
#include "apps/gonio/summary.h"
#include "brdf/open.h"
#include "core/error.h"

namespace gonio {
namespace {

// CPU time of this thread: what a task costs, however many run beside it.
class Stopwatch {
 public:
  explicit Stopwatch(double* seconds) : seconds_(seconds), begin_(Now()) {}
  ~Stopwatch() { *seconds_ += Now() - begin_; }
  Stopwatch(const Stopwatch&) = delete;
  Stopwatch& operator=(const Stopwatch&) = delete;

 private:
  static double Now() {
    timespec time{};
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
    return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
  }
  double* seconds_;
  double begin_;
};

class Task {
 public:
  Task(const FrontierSession& session, std::stop_token now, FrontierCell* cell)
      : session_(session),
        now_(std::move(now)),
        cell_(cell),
        truth_(OpenBrdf(session.material.path)),
        plan_(session.contestant.plan) {
    static const std::vector<std::string> kNone;
    FitToRig(session.rig.config, plan_);
    if (session.contestant.learned_prior) plan_.Believe(session.learned->prior);
    RefuseSeen(session.material, plan_.prior,
               session.learned != nullptr ? session.learned->hashes : kNone);
  }

  bool Run() {
    const std::vector<int>& budgets = session_.study.budgets;
    if (!session_.contestant.per_budget && !Measure(budgets.back())) return false;
    for (const int budget : budgets) {
      if (session_.contestant.per_budget && !Measure(budget)) return false;
      cell_->rows.push_back(Row(budget));
    }
    AddStops();
    return true;
  }

 private:
  bool Measure(int budget) {
    const Stopwatch watch(&cell_->session_s);
    plan_.max_poses = budget;
    const RigFile& rig_file = session_.rig;
    const std::unique_ptr<Planner> planner =
        MakePlanner(plan_, {.reachable = MeasurablePoses(rig_file.config, truth_.get()),
                            .costs = CostsOn(rig_file.config),
                            .noise = NoiseOn(rig_file.config),
                            .parts = PartsOn(rig_file.config),
                            .pca = session_.learned != nullptr ? session_.learned->pca : nullptr,
                            .seed = session_.seed});
    OpenedRig rig = OpenSimulated(rig_file, *truth_, session_.seed);
    summary_ = RunSession({rig_file.config, rig.devices, *rig.clock, *planner}, {},
                          {.after_pose = {}, .now = now_});
    if (summary_.outcome == SessionOutcome::kStopped) return false;
    if (summary_.outcome != SessionOutcome::kComplete) throw ConfigError(summary_.reason);
    if (summary_.poses.empty()) throw ConfigError("no pose could be measured");
    samples_ = summary_.Samples();
    return true;
  }

  // The reconstruction of the first `poses`, scored.
  FrontierRow Row(int budget) {
    FrontierRow row;
    row.budget = budget;
    row.poses = std::min(budget, static_cast<int>(samples_.size()));
    const SessionPose& last = summary_.poses[row.poses - 1];
    row.minutes = last.end.count() / 60;
    if (last.predicted_error) row.predicted_error = *last.predicted_error;
    try {
      const auto samples = std::span(samples_).first(row.poses);
      std::unique_ptr<Brdf> brdf;
      {
        const Stopwatch watch(&cell_->reconstruction_s);
        brdf = Reconstruct(session_.contestant.reconstruction, samples, plan_, session_.learned);
      }
      const Stopwatch watch(&cell_->scoring_s);
      Score(*truth_, *brdf, samples, session_.study, &row);
    } catch (const std::exception& e) {
      row.failure = e.what();
    }
    return row;
  }

  void AddStops() {
    const bool predicts =
        std::any_of(summary_.poses.begin(), summary_.poses.end(),
                    [](const SessionPose& pose) { return pose.predicted_error.has_value(); });
    if (!predicts || session_.contestant.per_budget) return;
    std::map<int, double> known;  // errors by poses
    for (const double target : session_.study.targets) {
      FrontierStop stop{.target = target};
      stop.poses = PosesToStop(summary_, target);
      if (stop.poses > 0) {
        stop.minutes = summary_.poses[stop.poses - 1].end.count() / 60;
        if (known.count(stop.poses) == 0) known[stop.poses] = Row(stop.poses).male;
        stop.male = known[stop.poses];
      }
      cell_->stops.push_back(stop);
    }
  }

  const FrontierSession& session_;
  const std::stop_token now_;
  FrontierCell* cell_;
  const std::unique_ptr<Brdf> truth_;
  Plan plan_;
  SessionSummary summary_;
  std::vector<BrdfSample> samples_;
};

}  // namespace

RigFile WithoutNoise(RigFile rig) {
  constexpr int kFullScale = 65535;
  const double finer = static_cast<double>(rig.config.camera.full_scale) / kFullScale;
  rig.config.camera.full_scale = kFullScale;
  RadiometryConfig& believed = rig.config.radiometry;
  believed.electrons_per_count *= finer;
  believed.read_noise = believed.dark_current = 0;
  believed.multiplicative_noise = believed.monitor_noise = 0;
  rig.simulation = {.rig = rig.simulation.rig,
                    .axes = rig.simulation.axes,
                    .responsivity = rig.simulation.responsivity,
                    .electrons_per_count = rig.simulation.electrons_per_count * finer};
  return rig;
}

bool RunFrontierSession(const FrontierSession& session, const std::stop_token& now,
                        FrontierCell* cell) {
  return Task(session, now, cell).Run();
}

}  // namespace gonio
