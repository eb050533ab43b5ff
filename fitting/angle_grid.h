// SPDX-License-Identifier: Apache-2.0
// A coarse grid over the half/difference angles, and a reflectance read on it.

#pragma once

#include <Eigen/Core>
#include <array>

#include "brdf/brdf.h"
#include "brdf/direction.h"

namespace gonio {

// H x D x P nodes; what lies between them is trilinear in (sqrt(theta_h), theta_d, phi_d):
//
//   theta_h   node h at (h / (H - 1))^2 * 90 deg: both ends, dense towards the mirror direction
//   theta_d   node d at d / (D - 1) * 90 deg: both ends
//   phi_d     node p at p / P * 180 deg; by reciprocity phi_d has period 180 deg, so that node P
//             is node 0
//
// About a quarter of the nodes have a direction below the horizon; interpolation next to the
// horizon uses them, so they want sane numbers (SampleOnGrid() gives them some). A plain value;
// safe to read from several threads.
class AngleGrid {
 public:
  // Preconditions: theta_h >= 2, theta_d >= 2, phi_d >= 1.
  AngleGrid(int theta_h, int theta_d, int phi_d);

  int theta_h_count() const { return theta_h_; }
  int theta_d_count() const { return theta_d_; }
  int phi_d_count() const { return phi_d_; }
  int size() const { return theta_h_ * theta_d_ * phi_d_; }

  // 0 <= h < theta_h_count(), 0 <= d < theta_d_count(), 0 <= p < phi_d_count(); phi_d runs fastest.
  int Index(int h, int d, int p) const { return (h * theta_d_ + d) * phi_d_ + p; }

  // The angles of a node, 0 <= index < size(); both ends included.
  HalfDiff Node(int index) const;

  // Where a reflectance is asked for a node's number: the node, but 0.01 deg away from theta_h = 0
  // and theta_d = 0, where phi_d means nothing, and 0.25 deg from grazing, where f_r does not.
  HalfDiff Inside(int index) const;

  // Whether Inside() has both directions above the horizon.
  bool Physical(int index) const;

  // The nodes around `angles` and their weights, which sum to 1; some may be 0, and a node may be
  // named twice. Angles beyond the ends of theta_h and theta_d are taken for the ends.
  struct Corner {
    int index = 0;
    double weight = 0;
  };
  std::array<Corner, 8> Locate(const HalfDiff& angles) const;

 private:
  int theta_h_;
  int theta_d_;
  int phi_d_;
};

// f_r [1/sr] at every node: row c is channel c, column i node i. Nodes that are not physical, and
// those where `brdf` knows nothing, is negative or is not finite in any channel, repeat the nearest
// node along theta_h that is known (the smaller theta_h if two are as near), or, in a column of
// theta_h without any, along theta_d, or along phi_d. Calls Eval once for each physical node.
// Throws ConfigError naming the reflectance if no node is known.
Eigen::MatrixXf SampleOnGrid(const Brdf& brdf, const AngleGrid& grid);

}  // namespace gonio
