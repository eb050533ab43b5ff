// SPDX-License-Identifier: Apache-2.0
#include "apps/gonio/report_facts.h"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "acquisition/session_costs.h"
#include "apps/gonio/build_rig.h"
#include "apps/gonio/open_any.h"
#include "apps/gonio/summary.h"
#include "brdf/metrics.h"
#include "core/config.h"
#include "core/error.h"
#include "core/sha256.h"
#include "core/units.h"

namespace gonio {
namespace {

using nlohmann::json;

constexpr double kThinnedShare = 0.3;  // of the theta_h rows: the published decimation
constexpr int kFirstErrorCount = 8;    // fewer poses say little of a fit with 126 parameters
constexpr int kCurveStride = 4;        // in phi_d; moves a MALE by well under 1 %

RigConfig RigOf(const SessionInfo& info) {
  return ReadRig(ConfigNode::Parse(info.rig_text, "the session's rig"), info.rig_text);
}

void ReadEvents(ReportFacts* facts) {
  Seconds begun(0);  // the session, or its last resume
  for (const SessionEvent& event : facts->session.events) {
    if (auto incident = IncidentOf(event)) facts->incidents.push_back(*std::move(incident));
    if (event.kind == "pose_rejected") {
      const json body = json::parse(event.body);
      facts->refusals.push_back({{RadFromDeg(body.at("theta_h_deg").get<double>()),
                                  RadFromDeg(body.at("theta_d_deg").get<double>()),
                                  RadFromDeg(body.at("phi_d_deg").get<double>())},
                                 body.at("message").get<std::string>()});
    } else if (event.kind == "error") {
      facts->device_errors.push_back(json::parse(event.body).at("message").get<std::string>());
    } else if (event.kind == "session_resumed") {
      begun = event.time;
    } else if (event.kind == "prepared") {
      facts->times.homing += event.time - begun;
    }
  }
}

void AddUpTimes(ReportFacts* facts) {
  SessionTimes& t = facts->times;
  for (const MeasuredPose& pose : facts->session.poses) {
    t.travel += pose.move_time;
    t.settling += facts->rig.motion.settle;
    t.exposing += pose.end - pose.start - pose.move_time - facts->rig.motion.settle;
    t.total = pose.end;
  }
  if (facts->session.end) t.total = facts->session.end->duration;
  t.other = std::max(Seconds(0), t.total - t.homing - t.travel - t.settling - t.exposing);
  const auto poses = static_cast<double>(facts->session.poses.size());
  if (!facts->session.info.imported.empty()) return;
  t.exposing_per_pose = poses > 0 ? t.exposing / poses : NominalExposing(facts->rig);
}

// A planner's costs, asked with what was then measured.
PredictedTimes PredictTimes(const std::vector<MeasuredPose>& poses, const RigConfig& rig) {
  const SessionCosts costs = CostsOn(rig);
  PredictedTimes times;
  double squares = 0;
  for (std::size_t i = 1; i < poses.size(); ++i) {
    const DirectionPair from = ToDirections(poses[i - 1].planned);
    const DirectionPair to = ToDirections(poses[i].planned);
    const Rgb& f_r = poses[i].samples.front().f_r;
    const Seconds predicted(costs.travel(from, to) + costs.pose(to, f_r) +
                            (poses[i].frames_wanted - 1) * costs.frame(to, f_r));
    const Seconds actual = poses[i].end - poses[i].start;
    ++times.poses;
    times.predicted += predicted;
    times.actual += actual;
    squares += std::pow((actual - predicted).count(), 2);
  }
  if (times.poses > 0) times.rms = Seconds(std::sqrt(squares / times.poses));
  return times;
}

void MakeFit(ReportFacts* facts) {
  try {
    facts->fit = FitOfSession(facts->dir);
  } catch (const ConfigError& e) {
    facts->no_fit = e.what();
  }
}

void OpenTruth(ReportFacts* facts) {
  const SessionInfo& info = facts->session.info;
  if (info.material_path.empty()) {
    facts->no_truth = "a real sample was measured";
    return;
  }
  try {
    facts->truth = OpenAny(info.material_path);
    if (!info.material_sha256.empty() && Sha256OfFile(info.material_path) != info.material_sha256) {
      facts->truth.reset();
      facts->no_truth = info.material_path + ": has changed since the session";
    }
  } catch (const ConfigError& e) {
    facts->no_truth = e.what();
  }
}

// What the planner expected, from the log: each pose carries what was expected before it.
std::vector<ErrorPoint> PlannerError(const SessionRecord& session) {
  std::vector<ErrorPoint> points;
  for (std::size_t i = 0; i < session.poses.size(); ++i) {
    if (const auto& error = session.poses[i].predicted_error) {
      points.push_back({static_cast<int>(i), *error});
    }
  }
  if (session.end && session.end->predicted_error) {
    points.push_back({static_cast<int>(session.poses.size()), *session.end->predicted_error});
  }
  return points;
}

// 8, 12, 16, 24, 32, ..., without those next to the last.
std::vector<int> ErrorCounts(int poses) {
  std::vector<int> counts;
  for (int n = kFirstErrorCount; n < 0.9 * poses; n *= 2) {
    const int between = n + n / 2;
    counts.push_back(n);
    if (between < 0.9 * poses) counts.push_back(between);
  }
  return counts;
}

// The fits the session would have ended with after fewer poses.
void FindTrueError(ReportFacts* facts) {
  const std::vector<BrdfSample> samples = facts->session.Samples();
  MetricOptions metric = AllCores();
  metric.phi_stride = kCurveStride;
  std::vector<ErrorPoint>& points = facts->true_error;
  const std::vector<int> counts = ErrorCounts(static_cast<int>(samples.size()));
  try {
    if (!counts.empty()) {
      const Prior prior = PriorOfSession(facts->session.info);
      for (const int n : counts) {
        const DsbrdfFit fit =
            FitDsbrdf({samples.data(), static_cast<std::size_t>(n)}, prior, facts->plan.fit);
        points.push_back({n, Compare(*facts->truth, fit, metric).male});
      }
    }
  } catch (const ConfigError& e) {  // its prior has moved, or the first poses gave no reading
    facts->no_true_error = e.what();
  }
  if (facts->male) points.push_back({static_cast<int>(samples.size()), *facts->male});
}

}  // namespace

ReportFacts GatherFacts(const std::filesystem::path& dir) {
  ReportFacts facts;
  facts.dir = dir;
  facts.session = ReadSession(dir);
  facts.plan = ParsePlan(facts.session.info.plan_text, facts.session.info.plan_path);
  // Nobody knows the rig of imported samples, and so not what else it would take.
  const bool imported = !facts.session.info.imported.empty();
  if (!imported) facts.rig = RigOf(facts.session.info);
  FitToRig(facts.rig, facts.plan);
  try {
    ReadEvents(&facts);
  } catch (const json::exception& e) {
    throw ConfigError((dir / kSessionFile).string() + ": is damaged: " + e.what());
  }
  AddUpTimes(&facts);
  if (!imported) {
    facts.predicted_times = PredictTimes(facts.session.poses, facts.rig);
    facts.dense = EstimateDenseScan(facts.rig, facts.times.exposing_per_pose);
    facts.thinned = EstimateDenseScan(facts.rig, facts.times.exposing_per_pose, kThinnedShare);
  }
  facts.planner_error = PlannerError(facts.session);
  MakeFit(&facts);
  OpenTruth(&facts);
  if (!facts.truth || !facts.fit) return facts;
  const ErrorMetrics metrics = Compare(*facts.truth, *facts.fit, AllCores());
  if (metrics.compared > 0) facts.male = metrics.male;
  FindTrueError(&facts);
  return facts;
}

HalfDiff AnglesOf(const MeasuredPose& pose) { return ToHalfDiff(pose.samples.front().directions); }

int LostReadings(const SessionRecord& session) {
  int lost = 0;
  for (const MeasuredPose& pose : session.poses) {
    for (const BrdfSample& sample : pose.samples) {
      lost += static_cast<int>((!sample.sigma.isFinite()).count());
    }
  }
  return lost;
}

}  // namespace gonio
