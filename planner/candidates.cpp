// SPDX-License-Identifier: Apache-2.0
#include "planner/candidates.h"

#include <cmath>

#include "core/units.h"

namespace gonio {
namespace {

bool Within(const HalfDiff& angles, double max_polar) {
  double cos_i = 0;
  double cos_o = 0;
  Cosines(angles, &cos_i, &cos_o);
  const double limit = std::cos(max_polar);
  return cos_i >= limit && cos_o >= limit;
}

// The phi_d of cell (row, column): the next point of the additive recurrence with the plastic
// number (M. Roberts' R2 sequence), moved towards 90 degrees until there is room above the horizon.
double SpreadPhi(double theta_h, double theta_d, int row, int column, double share,
                 const CandidateOptions& options) {
  const double u =
      std::fmod(0.5 + 0.7548776662466927 * row + 0.5698402909980532 * column + share, 1.0);
  constexpr int kSteps = 64;
  for (int step = 0; step < kSteps; ++step) {
    const double room = options.phi_span * (1 - static_cast<double>(step) / kSteps);
    const double phi = kPi / 2 + (u - 0.5) * room;
    if (Within({theta_h, theta_d, phi}, options.max_polar)) return phi;
  }
  return kPi / 2;
}

// At phi_d = 0 or, with light and detector exchanged, 180 degrees.
void AddInPlane(Candidate candidate, const Reachable& reachable,
                std::vector<Candidate>* candidates) {
  for (const double phi : {0.0, kPi}) {
    candidate.angles.phi_d = phi;
    candidate.directions = ToDirections(candidate.angles);
    if (!candidate.directions.above_horizon()) continue;
    if (reachable && !reachable(candidate.directions)) continue;
    candidate.angles.phi_d = 0;
    candidates->push_back(candidate);
    return;
  }
}

// The candidates of one cell.
void AddPhis(Candidate candidate, const CandidateOptions& options, const Reachable& reachable,
             std::vector<Candidate>* candidates) {
  if (options.phi == PhiChoice::kInPlane) return AddInPlane(candidate, reachable, candidates);
  const bool across = options.phi == PhiChoice::kAcross;
  HalfDiff& angles = candidate.angles;
  for (int i = 0; i < (across ? 1 : options.phi_choices); ++i) {
    angles.phi_d = across
                       ? kPi / 2
                       : SpreadPhi(angles.theta_h, angles.theta_d, candidate.row, candidate.column,
                                   static_cast<double>(i) / options.phi_choices, options);
    candidate.directions = ToDirections(angles);
    if (!candidate.directions.above_horizon()) continue;
    if (reachable && !reachable(candidate.directions)) continue;
    candidates->push_back(candidate);
  }
}

double SquaredDistance(const HalfDiff& angles, double theta_h, double theta_d) {
  const double dh = std::sqrt(angles.theta_h / (kPi / 2)) - std::sqrt(theta_h / (kPi / 2));
  const double dd = (angles.theta_d - theta_d) / (kPi / 2);
  return dh * dh + dd * dd;
}

}  // namespace

std::vector<Candidate> MakeCandidates(const CandidateOptions& options, const Reachable& reachable) {
  const auto theta_h_at = [&](double row) {
    const double u = row / options.theta_h_count;
    return (options.merl_spacing ? u * u : u) * kPi / 2;
  };
  std::vector<Candidate> candidates;
  for (int row = 0; row < options.theta_h_count; ++row) {
    for (int column = 0; column < options.theta_d_count; ++column) {
      Candidate candidate{.angles = {}, .directions = {}, .row = row, .column = column};
      candidate.angles.theta_h = theta_h_at(row + 0.5);
      candidate.angles.theta_d = (column + 0.5) / options.theta_d_count * kPi / 2;
      candidate.cell_area =
          (theta_h_at(row + 1) - theta_h_at(row)) * kPi / 2 / options.theta_d_count;
      AddPhis(candidate, options, reachable, &candidates);
    }
  }
  return candidates;
}

int NearestCandidate(const std::vector<Candidate>& candidates, double theta_h, double theta_d) {
  int nearest = -1;
  double least = 0;
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    const double distance = SquaredDistance(candidates[i].angles, theta_h, theta_d);
    if (nearest < 0 || distance < least) {
      nearest = static_cast<int>(i);
      least = distance;
    }
  }
  return nearest;
}

}  // namespace gonio
