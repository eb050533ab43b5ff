// SPDX-License-Identifier: Apache-2.0
#include "acquisition/geometry_calibration/find_target.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>

#include "core/check.h"

namespace gonio {
namespace {

// px to each side of a corner in which gradients are looked at: beyond the blur of a lens, within
// the squares.
constexpr int kWindow = 5;

// Counts above black, one per pixel. A Bayer mosaic is smoothed so that red, green and blue sites
// count alike everywhere; the kernel is symmetric and shifts nothing.
cv::Mat GreyOf(const Frame& frame) {
  cv::Mat grey(frame.height, frame.width, CV_32F);
  const int counts = CountsPerPixel(frame.layout);
  for (int y = 0; y < frame.height; ++y) {
    for (int x = 0; x < frame.width; ++x) {
      double sum = 0;
      for (int c = 0; c < counts; ++c) {
        sum += frame.counts[(static_cast<std::size_t>(y) * frame.width + x) * counts + c];
      }
      grey.at<float>(y, x) = static_cast<float>(sum / counts - frame.black_level);
    }
  }
  if (frame.layout != PixelLayout::kMono && frame.layout != PixelLayout::kRgb) {
    const cv::Mat kernel = (cv::Mat_<float>(1, 3) << 0.25F, 0.5F, 0.25F);
    cv::sepFilter2D(grey, grey, CV_32F, kernel, kernel, {-1, -1}, 0, cv::BORDER_REFLECT_101);
  }
  return grey;
}

using Corners = std::vector<Eigen::Vector2d>;

double Distance(const Corners& a, const Corners& b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i) sum += (a[i] - b[i]).squaredNorm();
  return sum;
}

// Rows, columns or both the other way round.
Corners Reordered(const Corners& corners, const Checkerboard& board, bool rows, bool columns) {
  Corners turned;
  for (int j = 0; j < board.rows; ++j) {
    for (int i = 0; i < board.columns; ++i) {
      const int row = rows ? board.rows - 1 - j : j;
      const int column = columns ? board.columns - 1 - i : i;
      turned.push_back(corners[static_cast<std::size_t>(row) * board.columns + column]);
    }
  }
  return turned;
}

}  // namespace

std::optional<Corners> FindCorners(const Frame& frame, int full_scale, const Checkerboard& board,
                                   const Corners& near) {
  GONIO_CHECK(static_cast<int>(near.size()) == board.corners(), "as many as the board has");
  const cv::Mat grey = GreyOf(frame);
  double brightest = 0;
  cv::minMaxLoc(grey, nullptr, &brightest);
  cv::Mat bytes;
  grey.convertTo(bytes, CV_8U, 255 / std::clamp<double>(brightest, 1, full_scale));
  std::vector<cv::Point2f> found;
  if (!cv::findChessboardCornersSB(bytes, {board.columns, board.rows}, found,
                                   cv::CALIB_CB_NORMALIZE_IMAGE)) {
    return std::nullopt;
  }
  // The sectors' fit is off by some hundredths of a pixel on a board seen aslant; where gradients
  // meet is not (Foerstner and Guelch, 1987).
  cv::cornerSubPix(grey, found, {kWindow, kWindow}, {-1, -1},
                   {cv::TermCriteria::EPS | cv::TermCriteria::COUNT, 50, 1e-4});
  Corners corners;
  for (const cv::Point2f& corner : found) corners.emplace_back(corner.x, corner.y);
  Corners best;
  double least = std::numeric_limits<double>::infinity();
  for (int order = 0; order < 4; ++order) {
    Corners turned = Reordered(corners, board, (order & 1) != 0, (order & 2) != 0);
    const double distance = Distance(turned, near);
    if (distance >= least) continue;
    least = distance;
    best = std::move(turned);
  }
  return best;
}

Result<Eigen::Vector2d> FindHighlight(const Frame& frame, int full_scale) {
  const cv::Mat grey = GreyOf(frame);
  double peak = 0;
  cv::minMaxLoc(grey, nullptr, &peak);
  const auto refuse = [](const char* what) {
    return Error{ErrorCode::kRefused, std::string("no highlight: ") + what};
  };
  if (peak + frame.black_level >= full_scale) return refuse("it is saturated");
  if (peak < 0.05 * full_scale) return refuse("nothing is bright");
  const double floor = 0.25 * peak;
  double sum = 0;
  Eigen::Vector2d moment = Eigen::Vector2d::Zero();
  int pixels = 0;
  bool cut = false;
  for (int y = 0; y < grey.rows; ++y) {
    for (int x = 0; x < grey.cols; ++x) {
      const double value = grey.at<float>(y, x) - floor;
      if (value <= 0) continue;
      cut = cut || x == 0 || y == 0 || x == grey.cols - 1 || y == grey.rows - 1;
      ++pixels;
      sum += value;
      moment += value * Eigen::Vector2d(x, y);
    }
  }
  if (cut) return refuse("it reaches to the image's border");
  if (pixels > 0.02 * grey.rows * grey.cols) return refuse("too much is as bright");
  return Eigen::Vector2d(moment / sum);
}

}  // namespace gonio
