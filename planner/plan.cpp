// SPDX-License-Identifier: Apache-2.0
#include "planner/plan.h"

#include <algorithm>

#include "core/config.h"
#include "core/error.h"
#include "core/file.h"
#include "core/units.h"
#include "planner/process_planner.h"

namespace gonio {
namespace {

constexpr int kMostPoses = 1000000;
constexpr int kProcessPhis = 4;
constexpr double kProcessPhiSpan = RadFromDeg(170);

CandidateOptions ReadCandidates(const ConfigNode& root) {
  CandidateOptions options;
  if (!root.Has("candidates")) return options;
  const ConfigNode node = root.Map("candidates");
  options.theta_h_count = node.IntegerOr("theta_h_count", options.theta_h_count, 1, 1000);
  options.theta_d_count = node.IntegerOr("theta_d_count", options.theta_d_count, 1, 1000);
  if (node.Has("spacing")) {
    options.merl_spacing = node.Choice("spacing", {"merl", "uniform"}) == "merl";
  }
  if (node.Has("phi_d")) {
    options.phi = node.Choice("phi_d", {"across", "spread"}) == "across" ? PhiChoice::kAcross
                                                                         : PhiChoice::kSpread;
  }
  options.phi_span = RadFromDeg(
      node.NumberOr("phi_span_deg", DegFromRad(options.phi_span), Range::Between(0, 180)));
  options.max_polar = RadFromDeg(
      node.NumberOr("max_polar_deg", DegFromRad(options.max_polar), Range::Between(10, 89.9)));
  return options;
}

void ReadFit(const ConfigNode& root, Plan* plan) {
  DsbrdfShape shape;
  std::string prior = "generic";
  if (root.Has("fit")) {
    const ConfigNode node = root.Map("fit");
    shape.lobes = node.IntegerOr("lobes", shape.lobes, 1, kMaxLobes);
    shape.knots = node.IntegerOr("knots", shape.knots, kMinKnots, kMaxKnots);
    prior = node.TextOr("prior", prior);
    FitOptions& fit = plan->fit;
    fit.floor = node.NumberOr("floor_per_sr", fit.floor, Range::Positive());
    fit.huber = node.NumberOr("huber", fit.huber, Range::Positive());
    fit.model_error = node.NumberOr("model_error", fit.model_error, Range::Positive());
    fit.model_error_weight =
        node.NumberOr("model_error_weight", fit.model_error_weight, Range::NonNegative());
    fit.max_iterations = node.IntegerOr("max_iterations", fit.max_iterations, 1, 10000);
    if (!IsBuiltInPrior(prior) && (node.Has("lobes") || node.Has("knots"))) {
      node.Fail("prior", "a prior file brings its own lobes and knots; leave those keys out");
    }
  }
  if (!IsBuiltInPrior(prior) && std::filesystem::path(prior).is_relative()) {
    prior = (std::filesystem::path(root.file()).parent_path() / prior).string();
  }
  plan->prior = OpenPrior(prior, shape);
}

void ReadInformation(const ConfigNode& root, InformationOptions* options) {
  if (!root.Has("information")) return;
  const ConfigNode node = root.Map("information");
  GainOptions& gain = options->gain;
  if (node.Has("objective")) {
    gain.objective = node.Choice("objective", {"male", "relative"}) == "male"
                         ? Objective::kMale
                         : Objective::kRelative;
  }
  options->target_error =
      node.NumberOr("target_error", options->target_error, Range::NonNegative());
  options->min_gain = node.NumberOr("min_gain", options->min_gain, Range::Between(0, 1));
  gain.max_polar = RadFromDeg(
      node.NumberOr("max_polar_deg", DegFromRad(gain.max_polar), Range::Between(10, 90)));
  gain.relative_noise = node.NumberOr("relative_noise", gain.relative_noise, Range::Positive());
  gain.repeat_length = node.NumberOr("repeat_length", gain.repeat_length, Range::Positive());
}

}  // namespace

bool IsBuiltInPrior(const std::string& name) { return name == "none" || name == "generic"; }

Prior OpenPrior(const std::string& name, const DsbrdfShape& shape) {
  if (name == "none") return NoPrior(shape);
  return name == "generic" ? GenericPrior(shape) : ReadPrior(name);
}

Plan ParsePlan(const std::string& text, const std::string& name) {
  const ConfigNode root = ConfigNode::Parse(text, name);
  Plan plan;
  root.Integer("version", 1, 1);
  plan.name = root.Text("name");
  plan.text = text;
  const std::string kind = root.Choice("planner", {"grid", "random", "information"});
  plan.kind = kind == "grid"     ? PlannerKind::kGrid
              : kind == "random" ? PlannerKind::kRandom
                                 : PlannerKind::kInformation;
  plan.max_poses = plan.kind == PlannerKind::kInformation
                       ? root.Integer("max_poses", 1, kMostPoses)
                       : root.IntegerOr("max_poses", 0, 0, kMostPoses);
  plan.candidates = ReadCandidates(root);
  if (plan.kind == PlannerKind::kGrid && root.Has("grid")) {
    const ConfigNode node = root.Map("grid");
    plan.raster.every_theta_h = node.IntegerOr("every_theta_h", 1, 1, 1000);
    plan.raster.every_theta_d = node.IntegerOr("every_theta_d", 1, 1, 1000);
  }
  if (plan.kind == PlannerKind::kInformation) ReadInformation(root, &plan.information);
  ReadFit(root, &plan);
  root.RefuseUnknownKeys();
  return plan;
}

Plan LoadPlan(const std::filesystem::path& path) {
  return ParsePlan(ReadTextFile(path), path.string());
}

namespace {

std::vector<Candidate> OfferedBy(const Plan& plan, const CandidateOptions& options,
                                 const Reachable& reachable) {
  std::vector<Candidate> candidates = MakeCandidates(options, reachable);
  if (candidates.empty()) {
    throw ConfigError("plan " + plan.name +
                      ": the rig cannot reach any of its poses: check the rig's axis limits, "
                      "geometry.max_polar_deg and geometry.min_separation_deg");
  }
  return candidates;
}

// Where a process was learned it plans: it sees all three angles, so cells get several phi_d.
std::unique_ptr<Planner> MakeProcessPlanner(const Plan& plan, const Reachable& reachable) {
  CandidateOptions candidates = plan.candidates;
  candidates.phi_choices = kProcessPhis;
  candidates.phi_span = std::max(candidates.phi_span, kProcessPhiSpan);
  ProcessPlannerOptions options;
  options.max_poses = plan.max_poses;
  options.target_error = plan.information.target_error;
  options.min_gain = plan.information.min_gain;
  options.gain.objective = plan.information.gain.objective;
  options.gain.max_polar = plan.information.gain.max_polar;
  options.gain.relative_noise = plan.information.gain.relative_noise;
  options.prior = plan.prior.process;
  return std::make_unique<ProcessPlanner>(OfferedBy(plan, candidates, reachable), options);
}

}  // namespace

std::unique_ptr<Planner> MakePlanner(const Plan& plan, const Reachable& reachable,
                                     std::uint64_t seed) {
  std::vector<Candidate> candidates = OfferedBy(plan, plan.candidates, reachable);
  switch (plan.kind) {
    case PlannerKind::kGrid: {
      RasterOptions raster = plan.raster;
      raster.max_poses = plan.max_poses;
      std::vector<int> order = RasterOrder(candidates, plan.candidates, raster);
      return std::make_unique<SequencePlanner>(std::move(candidates), std::move(order), "raster");
    }
    case PlannerKind::kRandom: {
      std::vector<int> order = RandomOrder(candidates.size(), plan.max_poses, seed);
      return std::make_unique<SequencePlanner>(std::move(candidates), std::move(order), "random");
    }
    case PlannerKind::kInformation: {
      if (plan.prior.process) return MakeProcessPlanner(plan, reachable);
      InformationOptions options = plan.information;
      options.max_poses = plan.max_poses;
      options.prior = plan.prior;
      options.fit = plan.fit;
      return std::make_unique<InformationPlanner>(std::move(candidates), std::move(options));
    }
  }
  GONIO_CHECK(false, "every kind of planner is handled");
}

}  // namespace gonio
