// SPDX-License-Identifier: Apache-2.0
// gonio replay: a session's decisions, samples and fit once more, from its log alone.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "acquisition/radiometry.h"
#include "acquisition/rereduction.h"
#include "acquisition/session_check.h"
#include "acquisition/session_history.h"
#include "apps/gonio/commands.h"
#include "apps/gonio/json_file.h"
#include "apps/gonio/open_any.h"
#include "apps/gonio/progress.h"
#include "apps/gonio/replay_fit.h"
#include "apps/gonio/replay_imported.h"
#include "apps/gonio/replay_other_plan.h"
#include "apps/gonio/session_setup.h"
#include "apps/gonio/summary.h"
#include "brdf/samples_csv.h"
#include "core/clock.h"
#include "core/error.h"
#include "core/units.h"

namespace gonio {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

// What a part of a session was run with.
struct Stage {
  SessionSetup setup;
  Calibrations calibrations;
};

Stage StageOf(const SessionInfo& info, const fs::path& calibration, const fs::path& session) {
  SessionChoice choice = ChoiceOf(info, session);
  if (!calibration.empty()) choice.calibration = calibration;
  Stage stage{.setup = SetUp(choice), .calibrations = LoadCopies(choice.calibration)};
  Believe(stage.calibrations, &stage.setup.rig.config);
  return stage;
}

class Replay {
 public:
  explicit Replay(const ReplayOptions& options)
      : options_(options), record_(ReadSession(options.session)), history_(HistoryOf(record_)) {}

  int Run() {
    if (!options_.out.empty() && !fs::create_directory(options_.out)) {
      throw ConfigError(options_.out.string() + ": exists already; name another");
    }
    if (!record_.info.imported.empty()) return ReplayImported(options_, record_);
    if (!options_.rig.empty()) {
      throw ConfigError("--rig: the session has a rig of its own; only imported ones need another");
    }
    const bool whole = Whole();
    const int code = whole ? Decisions() : (Decisions(), kFailed);
    std::vector<MeasuredPose> poses = record_.poses;
    if (options_.rereduce || !options_.calibration.empty()) Rereduce(&poses);
    if (options_.refit) {
      const Stage stage = StageOf(history_.parts.back().info, {}, options_.session);
      json_["refit"] = Refit(poses, stage.setup.plan.prior, stage.setup.plan.fit, options_.session,
                             options_.out);
    }
    if (!options_.plan.empty()) OtherPlan(poses);
    if (!options_.out.empty()) fmt::print("wrote            {}\n", options_.out.string());
    if (!options_.json.empty()) WriteJson(options_.json, json_);
    return code;
  }

 private:
  bool Whole() {
    const std::vector<std::string> damage = FindDamage(options_.session);
    for (const std::string& one : damage) fmt::print("damage           {}\n", one);
    json_["damage"] = damage;
    return damage.empty();
  }

  // Of a resume with accepted changes, every part by what it was run with.
  int Decisions() {
    const int turns = static_cast<int>(history_.turns.size());
    std::string first;
    for (std::size_t p = 0; p < history_.parts.size() && first.empty(); ++p) {
      const bool last = p + 1 == history_.parts.size();
      first = Decide(history_.parts[p], last ? turns : history_.parts[p + 1].turn, last);
    }
    json_["turns"] = turns;
    json_["first_difference"] = first.empty() ? json() : json(first);
    if (first.empty()) {
      fmt::print("decisions        {}: all as logged\n", turns);
      return kDone;
    }
    fmt::print("decisions        {}\n", first);
    return kFailed;
  }

  // The first difference; empty: none.
  std::string Decide(const SessionHistory::Part& part, int end, bool last) {
    const Stage stage = StageOf(part.info, {}, options_.session);
    if (HashOf(stage.setup.plan.prior) != part.info.prior_sha256) {
      throw ConfigError(
          fmt::format("prior \"{}\" is no longer the one that the session was run "
                      "with: what it decided by cannot be known",
                      part.info.prior_name));
    }
    const std::unique_ptr<Planner> planner = PlannerFor(stage.setup, part.info.seed);
    RetraceOptions options{.agree_from = part.turn, .end = end};
    if (part.turn > 0) {
      options.learn = IndexIn(CandidatesOf(stage.setup.plan, stage.setup.Measurable()));
    }
    if (options_.speed > 0) {
      options.visit = [&](int turn, const Proposal& proposal) {
        if (turn >= part.turn) Show(turn, proposal);
      };
    }
    const Retraced retraced = Retrace(record_, history_, stage.setup.rig.config, *planner, options);
    if (retraced.first) return retraced.first->what;
    return last ? EndDiffers(*planner) : std::string();
  }

  std::string EndDiffers(Planner& planner) const {
    if (!record_.end || record_.end->outcome != "complete") return {};
    if (planner.Next()) {
      return fmt::format("the log ends ({}), the planner would go on", record_.end->reason);
    }
    if (planner.reason() == record_.end->reason) return {};
    return fmt::format("the log ends for \"{}\", the planner now for \"{}\"", record_.end->reason,
                       planner.reason());
  }

  void Show(int turn, const Proposal& proposal) {
    const LoggedTurn& logged = history_.turns[turn];
    const HalfDiff at = ToHalfDiff(proposal.directions);
    std::string outcome = "refused";
    if (logged.pose > 0) {
      const MeasuredPose& pose = record_.poses[logged.pose - 1];
      clock_.SleepFor(pose.end - shown_);
      shown_ = pose.end;
      outcome = fmt::format("f_r {:.4g} {:.4g} {:.4g}", pose.samples.front().f_r[0],
                            pose.samples.front().f_r[1], pose.samples.front().f_r[2]);
      if (pose.predicted_error) outcome += fmt::format(", predicted {:.4f}", *pose.predicted_error);
    }
    fmt::print("{:>12} {:4} theta_h {:6.2f} theta_d {:6.2f} deg, {}: {}\n", ForPeople(shown_),
               turn + 1, DegFromRad(at.theta_h), DegFromRad(at.theta_d), proposal.reason, outcome);
    std::fflush(stdout);
  }

  void Rereduce(std::vector<MeasuredPose>* poses) {
    const Stage stage = StageOf(history_.parts.back().info, options_.calibration, options_.session);
    Rereduction rereduction(options_.session, stage.setup.rig.config, stage.calibrations,
                            history_.visits);
    int same = 0;
    int samples = 0;
    double largest = 0;
    std::string where;
    for (MeasuredPose& pose : *poses) {
      const auto reduced = rereduction.Of(pose);
      if (!reduced) throw std::runtime_error(reduced.error().message);
      const std::vector<BrdfSample> now = SamplesOf(*reduced);
      for (std::size_t i = 0; i < std::min(now.size(), pose.samples.size()); ++i, ++samples) {
        const Rgb change = (now[i].f_r / pose.samples[i].f_r - 1).abs();
        if ((now[i].f_r == pose.samples[i].f_r).all()) ++same;
        for (int c = 0; c < kChannels; ++c) {
          if (!(change[c] > largest) || !std::isfinite(now[i].sigma[c])) continue;
          largest = change[c];
          where = fmt::format(" (pose {}, {})", pose.pose, kChannelNames[c]);
        }
      }
      pose.samples = now;
    }
    fmt::print(
        "reduced again    {} samples, {} as they were to the last bit; the largest change "
        "is {:.3g} %{}\n",
        samples, same, 100 * largest, where);
    json_["rereduced"] = {{"samples", samples}, {"same", same}, {"largest_change", largest}};
    if (options_.out.empty()) return;
    std::vector<MeasuredSample> rows;
    for (const MeasuredPose& pose : *poses) {
      for (const BrdfSample& sample : pose.samples) {
        rows.push_back({pose.pose, sample, pose.end.count()});
      }
    }
    WriteSamplesCsv(options_.out / "samples.csv", rows, {"reduced again by gonio replay"});
  }

  void OtherPlan(const std::vector<MeasuredPose>& poses) {
    const Stage stage = StageOf(history_.parts.back().info, {}, options_.session);
    json_["other_plan"] =
        ReplayOtherPlan(options_.plan, stage.setup, poses, history_.parts.back().info.seed,
                        options_.session, options_.out);
  }

  const ReplayOptions& options_;
  const SessionRecord record_;
  const SessionHistory history_;
  SystemClock clock_{options_.speed > 0 ? options_.speed : 1};
  Seconds shown_{0};
  json json_;
};

}  // namespace

int ReplayCommand(const ReplayOptions& options) { return Replay(options).Run(); }

}  // namespace gonio
