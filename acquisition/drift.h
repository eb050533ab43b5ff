// SPDX-License-Identifier: Apache-2.0
// How the instrument's gain drifts over a session, from visits to one reference pose.
//
// The monitor divides out what the light does. What optics, camera gain and detector temperature do
// it does not see; a pose that is measured again and again does. Of one channel, visit k at time
// t_k reads
//
//   y_k = u(t_k) + e_k,    var(e_k) = s_k^2,    var(u(b) - u(a)) = q |b - a|
//
// in parts of the first visit's reading: a random walk u read with noise (a local level model:
// Durbin and Koopman, "Time Series Analysis by State Space Methods", 2012, section 2). Given all
// visits the expected u is a straight line between any two of them and level after the last. Its
// variance is that of the visits, smoothed by their neighbours, and what the walk can have done in
// between: q (t - a)(b - t) / (b - a), or q (t - t_n) after the last. The gain is
//
//   g(t) = u(t) / u(t_1)
//
// so the first visit's noise is in it. Not in it: what drifted between the calibration and the
// first visit, which only a standard can tell.
//
// q, the same for all channels, is where the likelihood of the visits times its prior peaks: an
// inverse chi^2 of two degrees of freedom about `expected_per_hour` squared. A drift of constant
// rate r looks like a walk of q = r^2 times the time between visits: its lag is within the stated
// sigma.

#pragma once

#include <array>
#include <optional>
#include <vector>

#include "brdf/brdf.h"
#include "brdf/direction.h"
#include "core/clock.h"
#include "core/config.h"

namespace gonio {

// The `drift` mapping of a rig file.
struct DriftPolicy {
  int every_poses = 0;               // measured poses from one visit to the next; 0: not by poses
  Seconds every{0};                  // from one visit to the next; 0: not by time
  std::optional<HalfDiff> pose;      // visited; empty: the first one that is measured
  int frames = 6;                    // of a visit, as far as exposure.max_frames goes
  double expected_per_hour = 0.01;   // relative: what to think of the drift before it is seen
  std::optional<double> max_change;  // of any channel's gain, relative; empty: whatever it is
  bool stop = false;                 // at more than that; otherwise it is said

  bool on() const { return every_poses > 0 || every > Seconds::zero(); }
};
// Throws ConfigError.
// `phi_d_deg`: of a pose that does not say.
DriftPolicy ReadDriftPolicy(const ConfigNode& node, double phi_d_deg = 90);

// What the reference pose gave: any number proportional to the gain.
struct ReferenceVisit {
  Seconds time{0};           // session clock
  Rgb signal = Rgb::Zero();  // f_r as if there were no drift
  Rgb sigma = Rgb::Zero();   // of its noise; infinite: not measured
};

// A gain over that at the first visit, with its standard uncertainty.
struct Gain {
  Rgb value = Rgb::Ones();
  Rgb sigma = Rgb::Zero();
};

class DriftTracker {
 public:
  explicit DriftTracker(double expected_per_hour);

  // Later than all before. Of the first visit of a channel the noise must be below a fifth of the
  // signal; otherwise, as without any visit, the channel's gain stays 1 +- 0: nothing is known.
  void Add(const ReferenceVisit& visit);

  // With all visits so far, at any time: before, between or after them.
  Gain At(Seconds time) const;

  int visits() const { return visits_; }
  double diffusion_per_hour() const { return diffusion_; }  // q

 private:
  struct Channel {
    double scale = 0;            // the first visit's reading
    std::vector<double> hours;   // of the visits that count
    std::vector<double> y;       // over scale
    std::vector<double> sigma;   // over scale
    std::vector<double> smooth;  // expected u, given all visits
  };

  double LogPosterior(double diffusion) const;
  // The inverse of the visits' joint covariance applied to `right`: tridiagonal.
  std::vector<double> Solve(const Channel& channel, std::vector<double> right) const;

  const double expected_;  // q, 1/hour
  double diffusion_;
  int visits_ = 0;
  std::array<Channel, kChannels> channels_;
};

}  // namespace gonio
