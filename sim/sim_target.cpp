// SPDX-License-Identifier: Apache-2.0
#include "sim/sim_target.h"

#include <Eigen/Geometry>
#include <cmath>

#include "core/units.h"

namespace gonio {
namespace {

// Where a pixel straddles an edge it is divided into so many by so many.
constexpr int kParts = 10;

}  // namespace

Eigen::Matrix3d SimTarget::Turned(const std::array<double, 3>& turn) {
  using Eigen::AngleAxisd, Eigen::Vector3d;
  return (AngleAxisd(turn[0], Vector3d::UnitX()) * AngleAxisd(turn[1], Vector3d::UnitY()) *
          AngleAxisd(turn[2], Vector3d::UnitZ()))
      .toRotationMatrix();
}

Eigen::Vector3d SimTarget::Into(const Eigen::Vector3d& point) const {
  return Turned(turn).transpose() * (point - Eigen::Map<const Eigen::Vector3d>(shift.data()));
}

Eigen::Vector3d SimTarget::OutOf(const Eigen::Vector3d& point) const {
  return Turned(turn) * point + Eigen::Map<const Eigen::Vector3d>(shift.data());
}

Eigen::Vector3d SimTarget::Normal() const { return Turned(turn).col(2); }

Rgb SimTarget::Mirror(const DirectionPair& local) const {
  const Eigen::Vector3d half = (local.wi + local.wo).normalized();
  const double cos2 = half.z() * half.z();
  const double slope2 = (1 - cos2) / cos2 / (kMirrorSlope * kMirrorSlope);
  const double density = std::exp(-slope2) / (kPi * kMirrorSlope * kMirrorSlope * cos2 * cos2);
  return Rgb::Constant(0.04 * density / (4 * local.wi.z() * local.wo.z()));
}

bool SimTarget::White(const Eigen::Vector3d& point) const {
  if (kind == Kind::kTrap) return std::hypot(point.x(), point.y()) > hole;
  const int column = static_cast<int>(std::floor(point.x() / square + (columns + 1) / 2.0));
  const int row = static_cast<int>(std::floor(point.y() / square + (rows + 1) / 2.0));
  if (column < 0 || row < 0 || column > columns || row > rows) return true;
  return (column + row) % 2 == 1;
}

Rgb SimTarget::Paint(const std::function<Eigen::Vector3d(double, double)>& at) const {
  int corners = 0;
  for (const double dy : {-0.5, 0.5}) {
    for (const double dx : {-0.5, 0.5}) corners += White(at(dx, dy)) ? 1 : 0;
  }
  double white = corners / 4.0;
  if (corners != 0 && corners != 4) {
    int parts = 0;
    for (int j = 0; j < kParts; ++j) {
      for (int i = 0; i < kParts; ++i) {
        parts += White(at((i + 0.5) / kParts - 0.5, (j + 0.5) / kParts - 0.5)) ? 1 : 0;
      }
    }
    white = static_cast<double>(parts) / (kParts * kParts);
  }
  const double black = kind == Kind::kTrap ? hole_albedo : kBlack;
  return Rgb::Constant((black + white * (kWhite - black)) / kPi);
}

}  // namespace gonio
