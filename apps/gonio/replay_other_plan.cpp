// SPDX-License-Identifier: Apache-2.0
#include "apps/gonio/replay_other_plan.h"

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>

#include "acquisition/radiometry.h"
#include "acquisition/session_costs.h"
#include "apps/gonio/locate.h"
#include "apps/gonio/open_any.h"
#include "apps/gonio/progress.h"
#include "apps/gonio/summary.h"
#include "core/file.h"
#include "core/units.h"

namespace gonio {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

// A reading stands for poses so near: half a degree in the halfway frame, and less at a highlight,
// whose width is in proportion to theta_h.
const double kNear = RadFromDeg(0.5);
constexpr double kNearShare = 0.05;  // of theta_h

bool Near(const HalfDiff& a, const HalfDiff& b) {
  const double near_h = std::min(kNear, RadFromDeg(0.02) + kNearShare * a.theta_h);
  return std::abs(a.theta_h - b.theta_h) < near_h && std::abs(a.theta_d - b.theta_d) < kNear;
}

// f_r of the sample as far as a session knows it.
class StandIn {
 public:
  StandIn(const std::vector<MeasuredPose>& poses, const Brdf& estimate, const RigConfig& rig)
      : poses_(poses), estimate_(estimate), rig_(rig) {}

  std::optional<BrdfSample> At(const DirectionPair& pair) {
    const HalfDiff at = ToHalfDiff(pair);
    for (const MeasuredPose& pose : poses_) {
      if (!Near(at, ToHalfDiff(pose.samples.front().directions))) continue;
      ++measured_;
      return pose.samples.front();
    }
    const std::optional<Rgb> f_r = estimate_.Eval(pair);
    if (!f_r) return std::nullopt;
    ++estimated_;
    return BrdfSample{
        .directions = pair,
        .f_r = *f_r,
        .sigma = ExpectedSigma(pair, *f_r, Rgb::Constant(rig_.dense_exposure.count()), rig_)};
  }

  int measured() const { return measured_; }
  int estimated() const { return estimated_; }

 private:
  const std::vector<MeasuredPose>& poses_;
  const Brdf& estimate_;
  const RigConfig& rig_;
  int measured_ = 0;
  int estimated_ = 0;
};

struct Choices {
  std::vector<BrdfSample> samples;
  std::string csv = "pose,theta_h_deg,theta_d_deg,phi_d_deg,score,reason,stands_in\n";
  Seconds duration{0};
  std::string reason;
  std::optional<double> predicted_error;
};

Choices Choose(Planner& planner, StandIn& stand_in, const SessionCosts& costs) {
  Choices choices;
  std::optional<DirectionPair> at;
  for (int n = 1; const auto next = planner.Next(); ++n) {
    const int measured = stand_in.measured();
    const std::optional<BrdfSample> sample = stand_in.At(next->directions);
    if (!sample) {
      planner.Reject(*next);
      continue;
    }
    const HalfDiff angles = ToHalfDiff(next->directions);
    choices.csv +=
        fmt::format("{},{:.6g},{:.6g},{:.6g},{:.6g},{},{}\n", n, DegFromRad(angles.theta_h),
                    DegFromRad(angles.theta_d), DegFromRad(angles.phi_d), next->score, next->reason,
                    stand_in.measured() > measured ? "reading" : "estimate");
    if (at) choices.duration += Seconds(costs.travel(*at, next->directions));
    choices.duration += Seconds(costs.pose(next->directions, sample->f_r));
    at = next->directions;
    choices.samples.push_back(*sample);
    planner.Observe(*next, *sample);
  }
  choices.reason = planner.reason();
  choices.predicted_error = planner.PredictedError();
  return choices;
}

}  // namespace

json ReplayOtherPlan(const std::string& name, const SessionSetup& setup,
                     const std::vector<MeasuredPose>& poses, std::uint64_t seed,
                     const fs::path& session, const fs::path& out) {
  const RigConfig& rig = setup.rig.config;
  Plan plan = LoadPlan(LocateConfig(name));
  FitToRig(rig, plan);
  const SessionCosts costs = CostsOn(rig);
  const std::unique_ptr<Planner> planner = MakePlanner(plan, {.reachable = setup.Measurable(),
                                                              .costs = costs,
                                                              .noise = NoiseOn(rig),
                                                              .parts = PartsOn(rig),
                                                              .seed = seed});
  const std::unique_ptr<Brdf> estimate = EstimateOfSession(session);
  StandIn stand_in(poses, *estimate, rig);
  const Choices choices = Choose(*planner, stand_in, costs);
  fmt::print("plan {}: {} poses, about {}, {}\n", plan.name, choices.samples.size(),
             ForPeople(choices.duration), choices.reason);
  fmt::print(
      "                 {} read what the session read within 0.5 deg, {} what its estimate "
      "says there: no measurement\n",
      stand_in.measured(), stand_in.estimated());
  json result = {{"plan", plan.name},
                 {"poses", choices.samples.size()},
                 {"duration_s", choices.duration.count()},
                 {"readings", stand_in.measured()},
                 {"estimates", stand_in.estimated()},
                 {"reason", choices.reason}};
  if (choices.predicted_error) {
    fmt::print("predicted error  {:.5f}\n", *choices.predicted_error);
    result["predicted_error"] = *choices.predicted_error;
  }
  if (!choices.samples.empty()) {
    const DsbrdfFit fit = FitDsbrdf(choices.samples, plan.prior, plan.fit);
    result["male_against_session"] = PrintMale(*estimate, fit, "the session's estimate");
  }
  if (!out.empty()) {
    WriteFileAtomically(out / "choices.csv", [&](std::ostream& file) { file << choices.csv; });
  }
  return result;
}

}  // namespace gonio
