// SPDX-License-Identifier: Apache-2.0
// Who decides where to look next.

#pragma once

#include <functional>
#include <optional>
#include <string>

#include "brdf/brdf.h"
#include "brdf/direction.h"

namespace gonio {

// A pose the planner wants measured, and why.
struct Proposal {
  DirectionPair directions;
  int candidate = 0;   // index into the candidate set
  double score = 0;    // what the planner maximised, in its own unit; larger is better
  std::string reason;  // one short phrase for the log: "opening", "information", "raster"
  int frames = 1;      // usable exposures wanted: the noise of several averages out
};

// Seconds from one pose to the next, all axes moving together; both poses within reach. Its answers
// depend on its arguments only. Injected because a planner knows no rig.
using TravelTime = std::function<double(const DirectionPair& from, const DirectionPair& to)>;

// What a pose costs on the rig; an empty function costs nothing.
struct SessionCosts {
  TravelTime travel = {};
  // Seconds of settling, exposing and reading out at a pose where f_r is about this [1/sr], ...
  std::function<double(const DirectionPair& pair, const Rgb& f_r)> pose = {};
  // ... and those of one more exposure there. Empty: one has to do.
  std::function<double(const DirectionPair& pair, const Rgb& f_r)> frame = {};
  int max_frames = 1;  // that a pose may have
};

// Standard deviation of a reading [1/sr] by the noise of one exposure, where f_r is about this.
using ExpectedNoise = std::function<Rgb(const DirectionPair& pair, const Rgb& f_r)>;

// A planner is a plain conversation, with no clock, no device and no file:
//
//   while (auto next = planner.Next()) planner.Observe(*next, Measure(*next));
//
// Promises, checked by tests/conformance/planner.h on every planner:
//
//   1. Next() returns only members of the candidate set it was built with.
//   2. Next() with no Observe() or Reject() in between repeats its answer.
//   3. A rejected pose is never proposed again.
//   4. The same candidates, seed and observations give the same proposals.
//   5. Next() returns nullopt after finitely many steps; reason() then says why.
//   6. Observe() and Reject() may tell of any candidate, as a resumed session with another plan
//      does: it counts as if it had been proposed.
//
// One thread.
class Planner {
 public:
  virtual ~Planner() = default;
  virtual std::optional<Proposal> Next() = 0;
  // `sample` was measured for `proposal`; its directions are the encoders', so a little off.
  virtual void Observe(const Proposal& proposal, const BrdfSample& sample) = 0;
  // What else the image of the pose that was just observed shows: the sample under other
  // directions, as a round sample has them. Planners that keep no fit have no use for it.
  virtual void AlsoObserve(const BrdfSample&) {}
  // The pose could not be measured: shadowed, saturated, out of reach.
  virtual void Reject(const Proposal& proposal) = 0;
  // Why Next() returned nullopt, for the log and the report: "pose budget reached", ...
  virtual std::string reason() const = 0;
  // How many poses this planner will propose at most; for progress and ETA.
  virtual int MaxPoses() const = 0;
  // The error the planner expects its fit to have now, in the metric it optimises (docs/
  // planning.md); empty for planners that keep no fit.
  virtual std::optional<double> PredictedError() const { return std::nullopt; }
  // f_r the planner expects at a pair, to choose the exposure with; empty if it has no idea.
  virtual std::optional<Rgb> Predict(const DirectionPair&) const { return std::nullopt; }
};

}  // namespace gonio
