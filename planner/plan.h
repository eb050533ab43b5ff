// SPDX-License-Identifier: Apache-2.0
// Plan files, and the planners they describe.

#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>

#include "fitting/pca_reflectance.h"
#include "planner/candidates.h"
#include "planner/information_planner.h"
#include "planner/planner.h"
#include "planner/sequence_planner.h"
#include "planner/slice_refinement_planner.h"

namespace gonio {

enum class PlannerKind {
  kGrid,
  kRandom,
  kInformation,
  kNielsen,  // planner/direction_lists.h, as the next two
  kPivotedQr,
  kFrost,
  kSlices,        // planner/slice_refinement_planner.h
  kHierarchical,  // planner/hierarchical_planner.h
};

// A plan file such as configs/plan-information.yaml, checked. docs/planning.md lists the keys.
struct Plan {
  std::string name;
  std::string text;  // the file as it was read, frozen into the session
  PlannerKind kind = PlannerKind::kInformation;
  int max_poses = 0;  // 0: no budget
  CandidateOptions candidates;
  RasterOptions raster;            // kGrid; max_poses above is put into it
  InformationOptions information;  // kInformation; max_poses above is put into it
  // kInformation with a learned process: gain per second, else gain per pose.
  bool mind_time = true;
  SliceRefinementOptions slices;  // kSlices; max_poses above is put into it

  // With what a session's samples are fitted in the end, whoever chose them.
  Prior prior;
  FitOptions fit;
  bool process_wanted = true;  // of a prior that has one; else a DSBRDF all the same

  // Takes another prior.
  void Believe(Prior believed);
  // For a rig whose directions always lie in one plane with the normal: whatever phi_d the file
  // asks for, the candidates are those of PhiChoice::kInPlane.
  void StayInPlane() { candidates.phi = PhiChoice::kInPlane; }
};

// Throws ConfigError naming file, line and key. A prior file is looked for beside the plan.
Plan LoadPlan(const std::filesystem::path& path);
// `name` stands for the file in messages, and relative prior files are looked for beside it.
Plan ParsePlan(const std::string& text, const std::string& name);

// The prior a user names: "none" (NoPrior()), "generic" (GenericPrior()), or a prior file. `shape`
// is for the first two.
bool IsBuiltInPrior(const std::string& name);
Prior OpenPrior(const std::string& name, const DsbrdfShape& shape);

// What a planner needs and a plan file cannot hold.
struct PlannerInputs {
  Reachable reachable = {};  // if empty, every candidate above the horizon is
  SessionCosts costs = {};   // kInformation with a learned process; kHierarchical: travel only
  ExpectedNoise noise = {};  // kInformation with a learned process; if empty, a default
  PartsOf parts = {};        // kInformation: what else the image of a pose shows
  std::shared_ptr<const PcaBasis> pca = nullptr;  // kPivotedQr, kFrost: required
  std::uint64_t seed = 0;                         // kRandom
};

// What such a planner chooses from: Proposal::candidate counts these. Throws ConfigError if there
// are none.
std::vector<Candidate> CandidatesOf(const Plan& plan, const Reachable& reachable);

// The planner of a plan over the candidates that are reachable. Throws ConfigError if there are
// none, or if the plan needs something that is not there.
std::unique_ptr<Planner> MakePlanner(const Plan& plan, const PlannerInputs& inputs);

}  // namespace gonio
