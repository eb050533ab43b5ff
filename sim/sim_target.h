// SPDX-License-Identifier: Apache-2.0
// What stands on the stage while geometry or glare are calibrated: a board, a mirror, a trap.

#pragma once

#include <Eigen/Core>
#include <array>
#include <functional>

#include "brdf/brdf.h"

namespace gonio {

// A plate whose frame is turned against the sample's and shifted: p = Rx Ry Rz (turn) q + shift.
//
// Board: (columns + 1) by (rows + 1) squares, black and white in turn, on endless white, with the
// target's origin in the middle; columns lie along x. Both paints are Lambertian.
// Mirror: black glass without end, whose polish leaves a highlight of some pixels: normals as
// Beckmann's with the slope kMirrorSlope, 4 % reflected.
// Trap: a round hole of `hole` radius about the origin of an endless white tile.
struct SimTarget {
  // Rx(turn[0]) Ry(turn[1]) Rz(turn[2]); turns in rad.
  static Eigen::Matrix3d Turned(const std::array<double, 3>& turn);

  enum class Kind { kNone, kCheckerboard, kMirror, kTrap };
  Kind kind = Kind::kNone;
  int columns = 0;  // inner corners
  int rows = 0;
  double square = 0;                      // m
  double hole = 0;                        // m
  double hole_albedo = 0;                 // a trap: nothing comes back
  std::array<double, 3> shift{};          // m
  std::array<double, 3> turn{};           // rad
  static constexpr double kWhite = 0.8;   // albedo
  static constexpr double kBlack = 0.05;  // albedo
  static constexpr double kMirrorSlope = 0.001;

  Eigen::Vector3d Into(const Eigen::Vector3d& point) const;
  Eigen::Vector3d OutOf(const Eigen::Vector3d& point) const;
  Eigen::Vector3d Normal() const;

  // f_r of the mirror for directions in its own frame.
  Rgb Mirror(const DirectionPair& local) const;

  // f_r of the board, averaged over a pixel. `at`: the point of the target that is seen so many
  // pixels beside the pixel's middle.
  Rgb Paint(const std::function<Eigen::Vector3d(double, double)>& at) const;

 private:
  bool White(const Eigen::Vector3d& point) const;
};

}  // namespace gonio
