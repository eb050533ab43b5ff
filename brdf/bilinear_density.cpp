// SPDX-License-Identifier: Apache-2.0
#include "brdf/bilinear_density.h"

#include <algorithm>
#include <cmath>

#include "core/check.h"

namespace gonio {
namespace {

// x in [0, 1] with a x + (b - a) x^2 / 2 = area: how far a trapezoid that begins with height a and
// would end with b must be followed.
double FollowTrapezoid(double a, double b, double area) {
  const double slope = b - a;
  const double root = std::sqrt(std::max(a * a + 2 * slope * area, 0.0));
  const double sum = a + root;
  return sum > 0 ? std::clamp(2 * area / sum, 0.0, 1.0) : 0;
}

}  // namespace

GridPlace PlaceOnGrid(double x, int count) {
  const double at = std::clamp(x, 0.0, 1.0) * (count - 1);
  const int index = std::min(static_cast<int>(at), count - 2);
  return {index, at - index};
}

BilinearDensity::BilinearDensity(const std::vector<float>& values, int grids, int rows, int columns)
    : rows_(rows),
      columns_(columns),
      value_(values.begin(), values.end()),
      left_(values.size()),
      below_(std::size_t(grids) * rows) {
  GONIO_CHECK(rows >= 2 && columns >= 2, "a grid has cells");
  for (int g = 0; g < grids; ++g) {
    const std::size_t first = std::size_t(g) * rows * columns;
    double row_before = 0;
    double total = 0;
    for (int y = 0; y < rows; ++y) {
      const std::size_t row = first + std::size_t(y) * columns;
      for (int x = 1; x < columns; ++x) {
        left_[row + x] = left_[row + x - 1] + 0.5 * (value_[row + x - 1] + value_[row + x]);
      }
      const double here = left_[row + columns - 1];
      if (y > 0) total += 0.5 * (row_before + here);
      below_[std::size_t(g) * rows + y] = total;
      row_before = here;
    }
    const double scale = total > 0 ? 1 / total : 0;
    for (std::size_t i = first; i < first + std::size_t(rows) * columns; ++i) {
      value_[i] *= scale;
      left_[i] *= scale;
    }
    for (int y = 0; y < rows; ++y) below_[std::size_t(g) * rows + y] *= scale;
  }
}

double BilinearDensity::Blend(const std::vector<double>& numbers, std::size_t at,
                              std::size_t stride, int g, double t) const {
  const double here = numbers[g * stride + at];
  return t == 0 ? here : (1 - t) * here + t * numbers[(g + 1) * stride + at];
}

Point2 BilinearDensity::ToUniform(Point2 at, int g, double t) const {
  const auto [x, fx] = PlaceOnGrid(at[0], columns_);
  const auto [y, fy] = PlaceOnGrid(at[1], rows_);
  const std::size_t stride = std::size_t(rows_) * columns_;
  const std::size_t row = std::size_t(y) * columns_;
  // A number of the row at y + fy.
  const auto along = [&, fy = fy](const std::vector<double>& numbers, std::size_t column) {
    return (1 - fy) * Blend(numbers, row + column, stride, g, t) +
           fy * Blend(numbers, row + columns_ + column, stride, g, t);
  };
  const double here = along(value_, x);
  const double next = along(value_, x + 1);
  const double left = along(left_, x) + fx * (here + 0.5 * fx * (next - here));
  const double row_total = along(left_, columns_ - 1);
  const double first = Blend(left_, row + columns_ - 1, stride, g, t);
  const double second = Blend(left_, row + 2 * std::size_t(columns_) - 1, stride, g, t);
  const double below = Blend(below_, y, rows_, g, t) + fy * (first + 0.5 * fy * (second - first));
  return {row_total > 0 ? std::clamp(left / row_total, 0.0, 1.0) : 0, std::clamp(below, 0.0, 1.0)};
}

Point2 BilinearDensity::FromUniform(Point2 u, int g) const {
  const double* below = below_.data() + std::size_t(g) * rows_;
  const int y = std::clamp(
      static_cast<int>(std::upper_bound(below, below + rows_, u[1]) - below) - 1, 0, rows_ - 2);
  const std::size_t row = (std::size_t(g) * rows_ + y) * columns_;
  const double first = left_[row + columns_ - 1];
  const double second = left_[row + 2 * std::size_t(columns_) - 1];
  const double fy = FollowTrapezoid(first, second, u[1] - below[y]);
  const auto along = [&](const std::vector<double>& numbers, std::size_t column) {
    return (1 - fy) * numbers[row + column] + fy * numbers[row + columns_ + column];
  };
  const double wanted = u[0] * along(left_, columns_ - 1);
  int x = 0;
  while (x < columns_ - 2 && along(left_, x + 1) <= wanted) ++x;
  const double fx =
      FollowTrapezoid(along(value_, x), along(value_, x + 1), wanted - along(left_, x));
  return {(x + fx) / (columns_ - 1), (y + fy) / (rows_ - 1)};
}

}  // namespace gonio
