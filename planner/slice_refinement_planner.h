// SPDX-License-Identifier: Apache-2.0
// Adaptive slices: refine where what the neighbours predict is wrong. No model, no database.

#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "planner/candidates.h"
#include "planner/planner.h"

namespace gonio {

struct SliceRefinementOptions {
  int max_poses = 0;         // >= 0; 0: until no candidate is left
  double floor = 0.1;        // 1/sr, > 0: what is predicted is y = ln(f_r + floor)
  double curiosity = 0.003;  // > 0: error of y assumed where the prediction seems perfect
  double borrowed = 0.15;    // 0 .. 1: trust in a curvature that a neighbouring slice lends
};

// In the manner of R. Vavra & J. Filip ("Adaptive Slices for Acquisition of Anisotropic BRDF",
// 2016/17), for an isotropic sample, whose slices are rows and columns of the candidates' raster:
//
//   1. Opening: three slices along theta_h (theta_d about 5, 40 and 75 deg) and three along theta_d
//      (at the peak, on its shoulder, off it), a dozen poses.
//   2. Between two neighbouring readings a step h apart on a slice, interpolating y errs by
//      h^2 k / 8, k the second difference of y there (at the worse end; lent by the nearest slice
//      of the same kind where there are too few readings), less what noise explains. An interval
//      counts by that error, times h, times how far it is to the slices on both sides.
//   3. The middle of the interval that counts most is measured. If that was on a slice along
//      theta_d, a new slice along theta_h starts there.
//   4. When no slice has anything left, one starts in the widest gap.
//
// h is counted in sqrt(theta_h / 90 deg) and in half of theta_d / 90 deg. Theirs works on a
// four-dimensional structure of slices in other angles and refines until an error threshold; ours
// takes one pose at a time, so that it can stop at any budget. Proposal::score is what the interval
// counts. Reconstruct with fitting/scattered_reflectance.h.
class SliceRefinementPlanner final : public Planner {
 public:
  // Precondition: candidates is not empty.
  SliceRefinementPlanner(std::vector<Candidate> candidates, const SliceRefinementOptions& options);

  std::optional<Proposal> Next() override;
  void Observe(const Proposal& proposal, const BrdfSample& sample) override;
  void Reject(const Proposal& proposal) override;
  std::string reason() const override { return reason_; }
  int MaxPoses() const override { return max_poses_; }

 private:
  enum Kind { kAlongThetaH, kAlongThetaD };
  struct Reading {
    Rgb y = Rgb::Zero();      // ln(f_r + floor), readings below 0 counting as 0
    Rgb noise = Rgb::Zero();  // its standard deviation
  };
  struct Slice {
    std::vector<int> members;  // candidates, along the slice
  };
  struct Knot {  // a reading on a slice
    std::size_t member = 0;
    double position = 0;
    double curvature = -1;  // second difference of y, mean of the channels; < 0: unknown
    double noise = 0;
  };
  struct Choice {
    int candidate = -1;
    Kind kind = kAlongThetaH;
    double score = -1;
  };
  using Slices = std::map<int, Slice>;  // by raster column or row

  double Position(Kind kind, int candidate) const;  // along a slice of that kind
  void StartSlice(Kind kind, int index);
  bool StartInWidestGap();
  Choice Choose() const;
  void ConsiderSlice(Kind kind, int index, const std::map<int, std::vector<Knot>>& knots,
                     Choice* best) const;
  std::vector<Knot> Knots(Kind kind, const Slice& slice) const;
  double Cover(Kind kind, int index) const;
  double Lent(const std::map<int, std::vector<Knot>>& knots, int index, double position) const;
  int NearestUnspent(Kind kind, const Slice& slice, std::size_t first, std::size_t last,
                     double position) const;
  Proposal Propose(const Choice& choice, const std::string& why) const;

  std::vector<Candidate> candidates_;
  SliceRefinementOptions options_;
  int max_poses_;
  std::vector<int> opening_;
  std::vector<char> spent_;                       // measured or rejected
  std::vector<std::optional<Reading>> readings_;  // by candidate
  Slices slices_[2];                              // by Kind
  int measured_ = 0;
  std::optional<Proposal> current_;
  Choice chosen_;
  std::string reason_;
};

}  // namespace gonio
