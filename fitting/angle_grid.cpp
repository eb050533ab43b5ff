// SPDX-License-Identifier: Apache-2.0
#include "fitting/angle_grid.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/check.h"
#include "core/error.h"
#include "core/units.h"

namespace gonio {
namespace {

constexpr double kRight = kPi / 2;
constexpr double kFromZero = RadFromDeg(0.01);
constexpr double kFromGrazing = RadFromDeg(0.25);

// A position between two nodes of one axis, counted in nodes.
struct Between {
  int low = 0, high = 0;
  double weight = 0;  // of `high`
};

Between PlaceClamped(double position, int count) {
  const double inside = std::clamp(position, 0.0, count - 1.0);
  const int low = std::min(static_cast<int>(inside), count - 2);
  return {low, low + 1, inside - low};
}

Between PlacePeriodic(double position, int count) {
  const double inside = position - std::floor(position / count) * count;
  const int low = std::min(static_cast<int>(inside), count - 1);
  return {low, (low + 1) % count, inside - low};
}

// Gives the unknown ones of `count` nodes, `stride` apart from `first`, the number of the nearest
// known one, the lower if two are as near. What is known grows only after all were looked at.
void FillLine(int first, int stride, int count, std::vector<char>* known, Eigen::MatrixXf* f_r) {
  std::vector<int> from(count, -1);
  for (int i = 0; i < count; ++i) {
    for (int step = 0; step < count && from[i] < 0; ++step) {
      for (const int j : {i - step, i + step}) {
        if (j >= 0 && j < count && (*known)[first + j * stride] && from[i] < 0) from[i] = j;
      }
    }
  }
  if (from[0] < 0) return;
  for (int i = 0; i < count; ++i) {
    f_r->col(first + i * stride) = f_r->col(first + from[i] * stride).eval();
    (*known)[first + i * stride] = true;
  }
}

}  // namespace

AngleGrid::AngleGrid(int theta_h, int theta_d, int phi_d)
    : theta_h_(theta_h), theta_d_(theta_d), phi_d_(phi_d) {
  GONIO_CHECK(theta_h >= 2 && theta_d >= 2 && phi_d >= 1, "a grid has both ends of an axis");
}

HalfDiff AngleGrid::Node(int index) const {
  const double u = static_cast<double>(index / phi_d_ / theta_d_) / (theta_h_ - 1);
  const double v = static_cast<double>(index / phi_d_ % theta_d_) / (theta_d_ - 1);
  return {u * u * kRight, v * kRight, static_cast<double>(index % phi_d_) / phi_d_ * kPi};
}

HalfDiff AngleGrid::Inside(int index) const {
  HalfDiff angles = Node(index);
  angles.theta_h = std::clamp(angles.theta_h, kFromZero, kRight - kFromGrazing);
  angles.theta_d = std::clamp(angles.theta_d, kFromZero, kRight - kFromGrazing);
  return angles;
}

bool AngleGrid::Physical(int index) const {
  double cos_i = 0;
  double cos_o = 0;
  Cosines(Inside(index), &cos_i, &cos_o);
  return cos_i > 0 && cos_o > 0;
}

std::array<AngleGrid::Corner, 8> AngleGrid::Locate(const HalfDiff& angles) const {
  const double u = std::sqrt(std::max(angles.theta_h, 0.0) / kRight);
  const Between h = PlaceClamped(u * (theta_h_ - 1), theta_h_);
  const Between d = PlaceClamped(angles.theta_d / kRight * (theta_d_ - 1), theta_d_);
  const Between p = PlacePeriodic(angles.phi_d / kPi * phi_d_, phi_d_);
  std::array<Corner, 8> corners;
  for (int corner = 0; corner < 8; ++corner) {
    const bool high_h = corner & 1, high_d = corner & 2, high_p = corner & 4;
    corners[corner] = {
        Index(high_h ? h.high : h.low, high_d ? d.high : d.low, high_p ? p.high : p.low),
        (high_h ? h.weight : 1 - h.weight) * (high_d ? d.weight : 1 - d.weight) *
            (high_p ? p.weight : 1 - p.weight)};
  }
  return corners;
}

Eigen::MatrixXf SampleOnGrid(const Brdf& brdf, const AngleGrid& grid) {
  Eigen::MatrixXf f_r = Eigen::MatrixXf::Zero(kChannels, grid.size());
  std::vector<char> known(grid.size(), false);
  for (int i = 0; i < grid.size(); ++i) {
    if (!grid.Physical(i)) continue;
    const std::optional<Rgb> here = brdf.Eval(grid.Inside(i));
    if (!here || !here->isFinite().all() || (*here < 0).any()) continue;
    f_r.col(i) = here->matrix().cast<float>();
    known[i] = true;
  }
  if (std::find(known.begin(), known.end(), true) == known.end()) {
    throw ConfigError(brdf.name() + ": has no value on a grid over all angles");
  }
  const int rows = grid.theta_h_count(), columns = grid.theta_d_count(), phis = grid.phi_d_count();
  for (int d = 0; d < columns; ++d) {
    for (int p = 0; p < phis; ++p) {
      FillLine(grid.Index(0, d, p), columns * phis, rows, &known, &f_r);
    }
  }
  for (int h = 0; h < rows; ++h) {
    for (int p = 0; p < phis; ++p) FillLine(grid.Index(h, 0, p), phis, columns, &known, &f_r);
  }
  for (int h = 0; h < rows; ++h) {
    for (int d = 0; d < columns; ++d) FillLine(grid.Index(h, d, 0), 1, phis, &known, &f_r);
  }
  return f_r;
}

}  // namespace gonio
