// SPDX-License-Identifier: Apache-2.0
// The corners of a chequerboard and the highlight in a mirror, to a fraction of a pixel.

#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "core/error.h"
#include "drivers/camera.h"

namespace gonio {

// A flat board of (columns + 1) by (rows + 1) squares. Columns and rows count the inner corners and
// must differ, or a quarter turn could not be told.
struct Checkerboard {
  int columns = 9;
  int rows = 6;
  double square = 0.005;  // m

  // The inner corner in this column and row, in the board's frame: its origin is the middle.
  Eigen::Vector2d Corner(int column, int row) const {
    return {(column - (columns - 1) / 2.0) * square, (row - (rows - 1) / 2.0) * square};
  }
  int corners() const { return columns * rows; }
};

// Row by row, in pixels: (0, 0) is the middle of the first pixel. Which end of the board is first,
// the image does not say: `near` are the corners where they are believed to be, in order, and of
// the four orders the one that fits them best is taken. Empty: not all corners were found.
//
// Sectors about each corner are fitted (Duda and Frese, BMVC 2018, as OpenCV has it) and then the
// point where all gradients meet is found. That needs
// squares of some ten pixels: a region of 64 pixels is too small for a board.
std::optional<std::vector<Eigen::Vector2d>> FindCorners(const Frame& frame, int full_scale,
                                                        const Checkerboard& board,
                                                        const std::vector<Eigen::Vector2d>& near);

// Centroid of what is brighter than a quarter of the peak, about the peak. kRefused: no highlight:
// nothing stands out, it is saturated, it is cut off by the border, or too much of the frame is as
// bright.
Result<Eigen::Vector2d> FindHighlight(const Frame& frame, int full_scale);

}  // namespace gonio
