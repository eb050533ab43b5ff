// SPDX-License-Identifier: Apache-2.0
// Densities on the unit square, given at the points of a grid, and the maps that make them uniform.

#pragma once

#include <array>
#include <vector>

namespace gonio {

using Point2 = std::array<double, 2>;  // x runs along the columns, y along the rows

// Where a coordinate in [0, 1] lies between `count` >= 2 equidistant points.
struct GridPlace {
  int index = 0;        // of the point before, 0 .. count - 2
  double fraction = 0;  // 0 .. 1 on the way to the next
};
GridPlace PlaceOnGrid(double x, int count);

// A density that is bilinear between grid points and, between two such grids, a blend of both. Each
// grid is scaled to integrate to 1 in units of its cells.
class BilinearDensity {
 public:
  BilinearDensity() = default;
  // `values`: grids x rows x columns, each >= 0; a grid of zeros alone stays one.
  BilinearDensity(const std::vector<float>& values, int grids, int rows, int columns);

  // (1 - t) of grid g and t of grid g + 1: where uniform points are to be found, that is, the share
  // of the density below y, and the share left of x in the row there. Both in [0, 1].
  Point2 ToUniform(Point2 at, int g, double t) const;
  // The inverse, for one grid alone.
  Point2 FromUniform(Point2 u, int g) const;

 private:
  // What ToUniform reads at one grid point or row, of both grids at once.
  double Blend(const std::vector<double>& numbers, std::size_t at, std::size_t stride, int g,
               double t) const;

  int rows_ = 0, columns_ = 0;
  std::vector<double> value_;  // grids x rows x columns
  std::vector<double> left_;   // integral along the row from its begin to each point
  std::vector<double> below_;  // grids x rows: integral over all rows up to this one
};

}  // namespace gonio
