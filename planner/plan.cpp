// SPDX-License-Identifier: Apache-2.0
#include "planner/plan.h"

#include <algorithm>
#include <map>
#include <vector>

#include "core/config.h"
#include "core/error.h"
#include "core/file.h"
#include "core/units.h"
#include "planner/direction_lists.h"
#include "planner/hierarchical_planner.h"
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
    if (node.Has("model")) {
      plan->process_wanted = node.Choice("model", {"process", "dsbrdf"}) == "process";
    }
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
  plan->Believe(OpenPrior(prior, shape));
}

void ReadInformation(const ConfigNode& root, Plan* plan) {
  if (!root.Has("information")) return;
  const ConfigNode node = root.Map("information");
  InformationOptions* options = &plan->information;
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
  plan->mind_time = node.BoolOr("travel", plan->mind_time);
}

void ReadSlices(const ConfigNode& root, SliceRefinementOptions* options) {
  if (!root.Has("slices")) return;
  const ConfigNode node = root.Map("slices");
  options->floor = node.NumberOr("floor_per_sr", options->floor, Range::Positive());
  options->curiosity = node.NumberOr("curiosity", options->curiosity, Range::Positive());
  options->borrowed = node.NumberOr("borrowed", options->borrowed, Range::Between(0, 1));
}

const std::map<std::string, PlannerKind> kKinds = {{"grid", PlannerKind::kGrid},
                                                   {"random", PlannerKind::kRandom},
                                                   {"information", PlannerKind::kInformation},
                                                   {"nielsen", PlannerKind::kNielsen},
                                                   {"pivoted-qr", PlannerKind::kPivotedQr},
                                                   {"frost", PlannerKind::kFrost},
                                                   {"slices", PlannerKind::kSlices},
                                                   {"hierarchical", PlannerKind::kHierarchical}};

PlannerKind ReadKind(const ConfigNode& root) {
  std::vector<std::string> names;
  for (const auto& [name, kind] : kKinds) names.push_back(name);
  return kKinds.at(root.Choice("planner", names));
}

// Whether "no budget" would make no sense: the planner could go on for ever, or its directions
// depend on how many there will be.
bool NeedsBudget(PlannerKind kind) {
  return kind == PlannerKind::kInformation || kind == PlannerKind::kPivotedQr ||
         kind == PlannerKind::kFrost;
}

// The order of a plan whose poses are known beforehand.
std::vector<int> ListedOrder(const Plan& plan, const std::vector<Candidate>& candidates,
                             const PlannerInputs& inputs) {
  if (plan.kind == PlannerKind::kRandom) {
    return RandomOrder(candidates.size(), plan.max_poses, inputs.seed);
  }
  if (plan.kind == PlannerKind::kNielsen) {
    std::vector<int> order = NielsenOrder(candidates);
    const auto budget = static_cast<std::size_t>(plan.max_poses);
    if (budget > 0 && order.size() > budget) order.resize(budget);
    return order;
  }
  if (plan.kind == PlannerKind::kGrid) {
    RasterOptions raster = plan.raster;
    raster.max_poses = plan.max_poses;
    return RasterOrder(candidates, plan.candidates, raster);
  }
  if (inputs.pca == nullptr) {
    throw ConfigError("plan " + plan.name +
                      ": its directions are computed from training materials, and none were given");
  }
  return plan.kind == PlannerKind::kFrost ? FrostOrder(candidates, *inputs.pca, plan.max_poses)
                                          : PivotedOrder(candidates, *inputs.pca, plan.max_poses);
}

// Where a process was learned it plans.
bool PlansByProcess(const Plan& plan) {
  return plan.kind == PlannerKind::kInformation && plan.prior.process;
}

std::unique_ptr<Planner> MakeProcessPlanner(const Plan& plan, const PlannerInputs& inputs) {
  ProcessPlannerOptions options;
  options.max_poses = plan.max_poses;
  options.target_error = plan.information.target_error;
  options.min_gain = plan.information.min_gain;
  options.gain.objective = plan.information.gain.objective;
  options.gain.max_polar = plan.information.gain.max_polar;
  options.gain.relative_noise = plan.information.gain.relative_noise;
  options.gain.noise = inputs.noise;
  options.gain.parts = inputs.parts;
  options.prior = plan.prior.process;
  return std::make_unique<ProcessPlanner>(CandidatesOf(plan, inputs.reachable), options,
                                          plan.mind_time ? inputs.costs : SessionCosts{});
}

// Proposal::reason of a plan whose poses are known beforehand.
const char* Label(PlannerKind kind) {
  switch (kind) {
    case PlannerKind::kGrid:
      return "raster";
    case PlannerKind::kRandom:
      return "random";
    case PlannerKind::kNielsen:
      return "published direction";
    case PlannerKind::kPivotedQr:
      return "pivoted QR";
    default:
      return "FROST";
  }
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
  plan.kind = ReadKind(root);
  plan.max_poses = NeedsBudget(plan.kind) ? root.Integer("max_poses", 1, kMostPoses)
                                          : root.IntegerOr("max_poses", 0, 0, kMostPoses);
  plan.candidates = ReadCandidates(root);
  if (plan.kind == PlannerKind::kGrid && root.Has("grid")) {
    const ConfigNode node = root.Map("grid");
    plan.raster.every_theta_h = node.IntegerOr("every_theta_h", 1, 1, 1000);
    plan.raster.every_theta_d = node.IntegerOr("every_theta_d", 1, 1, 1000);
  }
  if (plan.kind == PlannerKind::kInformation) ReadInformation(root, &plan);
  if (plan.kind == PlannerKind::kSlices) ReadSlices(root, &plan.slices);
  ReadFit(root, &plan);
  root.RefuseUnknownKeys();
  return plan;
}

void Plan::Believe(Prior believed) {
  prior = std::move(believed);
  if (!process_wanted) prior.process = nullptr;
}

Plan LoadPlan(const std::filesystem::path& path) {
  return ParsePlan(ReadTextFile(path), path.string());
}

std::vector<Candidate> CandidatesOf(const Plan& plan, const Reachable& reachable) {
  CandidateOptions options = plan.candidates;
  if (PlansByProcess(plan)) {  // it sees all three angles, so cells get several phi_d
    options.phi_choices = kProcessPhis;
    options.phi_span = std::max(options.phi_span, kProcessPhiSpan);
  }
  std::vector<Candidate> candidates = MakeCandidates(options, reachable);
  if (candidates.empty()) {
    throw ConfigError("plan " + plan.name +
                      ": the rig cannot reach any of its poses: check the rig's axis limits, "
                      "geometry.max_polar_deg and geometry.min_separation_deg");
  }
  return candidates;
}

std::unique_ptr<Planner> MakePlanner(const Plan& plan, const PlannerInputs& inputs) {
  if (PlansByProcess(plan)) return MakeProcessPlanner(plan, inputs);
  std::vector<Candidate> candidates = CandidatesOf(plan, inputs.reachable);
  switch (plan.kind) {
    case PlannerKind::kInformation: {
      InformationOptions options = plan.information;
      options.max_poses = plan.max_poses;
      options.prior = plan.prior;
      options.fit = plan.fit;
      options.gain.parts = inputs.parts;
      return std::make_unique<InformationPlanner>(std::move(candidates), std::move(options));
    }
    case PlannerKind::kSlices: {
      SliceRefinementOptions options = plan.slices;
      options.max_poses = plan.max_poses;
      return std::make_unique<SliceRefinementPlanner>(std::move(candidates), options);
    }
    case PlannerKind::kHierarchical:
      return std::make_unique<HierarchicalPlanner>(std::move(candidates),
                                                   HierarchicalOptions{.max_poses = plan.max_poses},
                                                   inputs.costs.travel);
    default: {
      std::vector<int> order = ListedOrder(plan, candidates, inputs);
      return std::make_unique<SequencePlanner>(std::move(candidates), std::move(order),
                                               Label(plan.kind));
    }
  }
}

}  // namespace gonio
