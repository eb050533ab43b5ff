// SPDX-License-Identifier: Apache-2.0
// LDR-FLIP: P. Andersson, J. Nilsson, T. Akenine-Moeller, M. Oskarsson, K. Astroem, M. Fairchild,
// "FLIP: A Difference Evaluator for Alternating Images", Proc. ACM CGIT (HPG) 3(2), 2020. Symbols
// are the paper's.

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "brdf/render/image_metrics.h"
#include "core/check.h"
#include "core/units.h"

namespace gonio {
namespace {

using Colour = Eigen::Array3d;

constexpr double kQc = 0.7, kPc = 0.4, kPt = 0.95;  // colour: exponent, where and to what it bends
constexpr double kQf = 0.5;                         // features: exponent
constexpr double kFeatureWidth = 0.082;             // degrees

double Decode(double code) {  // sRGB, IEC 61966-2-1
  return code <= 0.04045 ? code / 12.92 : std::pow((code + 0.055) / 1.055, 2.4);
}

const Eigen::Matrix3d& XyzFromRgb() {  // linear Rec. 709, D65
  static const Eigen::Matrix3d matrix =
      (Eigen::Matrix3d() << 10135552. / 24577794, 8788810. / 24577794, 4435075. / 24577794,
       2613072. / 12288897, 8788810. / 12288897, 887015. / 12288897, 1425312. / 73733382,
       8788810. / 73733382, 70074185. / 73733382)
          .finished();
  return matrix;
}
const Colour& White() {
  static const Colour white = (XyzFromRgb() * Eigen::Vector3d::Ones()).array();
  return white;
}

// Relative to white.
Colour XyzOf(const Colour& linear) { return (XyzFromRgb() * linear.matrix()).array() / White(); }
Colour YCxCzOf(const Colour& linear) {  // a linear version of L*a*b*
  const Colour xyz = XyzOf(linear);
  return {116 * xyz[1] - 16, 500 * (xyz[0] - xyz[1]), 200 * (xyz[1] - xyz[2])};
}
Colour LinearOfYCxCz(const Colour& c) {
  const double y = (c[0] + 16) / 116;
  const Colour xyz(y + c[1] / 500, y, y - c[2] / 200);
  static const Eigen::Matrix3d inverse = XyzFromRgb().inverse();
  return (inverse * (xyz * White()).matrix()).array();
}

// L*a*b* with the Hunt effect: colours of dark things differ less.
Colour HuntLabOf(const Colour& linear) {
  const auto f = [](double t) {
    constexpr double kDelta = 6.0 / 29;
    return t > kDelta * kDelta * kDelta ? std::cbrt(t) : t / (3 * kDelta * kDelta) + 4.0 / 29;
  };
  const Colour xyz = XyzOf(linear);
  const double l = 116 * f(xyz[1]) - 16;
  return {l, 0.01 * l * 500 * (f(xyz[0]) - f(xyz[1])), 0.01 * l * 200 * (f(xyz[1]) - f(xyz[2]))};
}

double HyAb(const Colour& a, const Colour& b) {
  return std::abs(a[0] - b[0]) + std::hypot(a[1] - b[1], a[2] - b[2]);
}

// The contrast sensitivity of one channel as a filter: a sum of two Gaussians of unit area.
cv::Mat SensitivityFilter(double a1, double b1, double a2, double b2, double pixels_per_degree) {
  constexpr double kWidest = 0.04;  // the largest b of the three channels
  const int r =
      static_cast<int>(std::ceil(3 * std::sqrt(kWidest / (2 * kPi * kPi)) * pixels_per_degree));
  cv::Mat filter(2 * r + 1, 2 * r + 1, CV_64F);
  for (int y = -r; y <= r; ++y) {
    for (int x = -r; x <= r; ++x) {
      const double d2 = (x * x + y * y) / (pixels_per_degree * pixels_per_degree);
      filter.at<double>(y + r, x + r) = a1 * std::sqrt(kPi / b1) * std::exp(-kPi * kPi * d2 / b1) +
                                        a2 * std::sqrt(kPi / b2) * std::exp(-kPi * kPi * d2 / b2);
    }
  }
  return filter / cv::sum(filter)[0];
}

cv::Mat Filtered(const cv::Mat& image, const cv::Mat& filter) {
  cv::Mat result;
  cv::filter2D(image, result, CV_64F, filter, cv::Point(-1, -1), 0, cv::BORDER_REPLICATE);
  return result;
}

// The three planes of an image in YCxCz.
std::vector<cv::Mat> Planes(const Image& image) {
  std::vector<cv::Mat> planes(3);
  for (cv::Mat& plane : planes) plane.create(image.height, image.width, CV_64F);
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      const Colour code = image.at(x, y).cast<double>();
      const Colour c = YCxCzOf(code.unaryExpr(&Decode));
      for (int k = 0; k < 3; ++k) planes[k].at<double>(y, x) = c[k];
    }
  }
  return planes;
}

// What an eye at this distance sees, in Hunt-adjusted L*a*b*.
std::vector<Colour> Seen(const std::vector<cv::Mat>& planes, double pixels_per_degree) {
  const cv::Mat y = Filtered(planes[0], SensitivityFilter(1, 0.0047, 0, 1e-5, pixels_per_degree));
  const cv::Mat cx = Filtered(planes[1], SensitivityFilter(1, 0.0053, 0, 1e-5, pixels_per_degree));
  const cv::Mat cz =
      Filtered(planes[2], SensitivityFilter(34.1, 0.04, 13.5, 0.025, pixels_per_degree));
  std::vector<Colour> seen;
  for (int row = 0; row < y.rows; ++row) {
    for (int column = 0; column < y.cols; ++column) {
      const Colour c(y.at<double>(row, column), cx.at<double>(row, column),
                     cz.at<double>(row, column));
      seen.push_back(HuntLabOf(LinearOfYCxCz(c).max(0).min(1)));
    }
  }
  return seen;
}

// Edges (first derivative) or points (second), along x.
cv::Mat FeatureFilter(bool points, double pixels_per_degree) {
  const double sd = 0.5 * kFeatureWidth * pixels_per_degree;
  const int r = static_cast<int>(std::ceil(3 * sd));
  cv::Mat filter(2 * r + 1, 2 * r + 1, CV_64F);
  double positive = 0;
  double negative = 0;
  for (int y = -r; y <= r; ++y) {
    for (int x = -r; x <= r; ++x) {
      const double g = std::exp(-(x * x + y * y) / (2 * sd * sd));
      const double weight = points ? (x * x / (sd * sd) - 1) * g : -x * g;
      filter.at<double>(y + r, x + r) = weight;
      (weight > 0 ? positive : negative) += std::abs(weight);
    }
  }
  for (auto it = filter.begin<double>(); it != filter.end<double>(); ++it) {
    *it /= *it > 0 ? positive : negative;
  }
  return filter;
}

cv::Mat FeatureStrength(const cv::Mat& brightness, const cv::Mat& filter) {
  cv::Mat strength;
  cv::magnitude(Filtered(brightness, filter), Filtered(brightness, filter.t()), strength);
  return strength;
}

double ColourDifference(const Colour& a, const Colour& b) {
  static const double max =
      std::pow(HyAb(HuntLabOf({0, 1, 0}), HuntLabOf({0, 0, 1})), kQc);  // green against blue
  const double d = std::pow(HyAb(a, b), kQc);
  const double bend = kPc * max;
  return d < bend ? kPt / bend * d : kPt + (d - bend) / (max - bend) * (1 - kPt);
}

}  // namespace

double Flip(const Image& reference, const Image& other, double pixels_per_degree) {
  GONIO_CHECK(reference.width == other.width && reference.height == other.height, "same size");
  const std::vector<cv::Mat> a = Planes(reference);
  const std::vector<cv::Mat> b = Planes(other);
  const std::vector<Colour> seen_a = Seen(a, pixels_per_degree);
  const std::vector<Colour> seen_b = Seen(b, pixels_per_degree);
  const cv::Mat bright_a = (a[0] + 16) / 116;
  const cv::Mat bright_b = (b[0] + 16) / 116;
  const cv::Mat edge = FeatureFilter(false, pixels_per_degree);
  const cv::Mat point = FeatureFilter(true, pixels_per_degree);
  cv::Mat edges;
  cv::Mat points;
  cv::absdiff(FeatureStrength(bright_a, edge), FeatureStrength(bright_b, edge), edges);
  cv::absdiff(FeatureStrength(bright_a, point), FeatureStrength(bright_b, point), points);
  double sum = 0;
  for (std::size_t i = 0; i < seen_a.size(); ++i) {
    const int y = static_cast<int>(i) / reference.width;
    const int x = static_cast<int>(i) % reference.width;
    const double feature =
        std::pow(std::max(edges.at<double>(y, x), points.at<double>(y, x)) / std::sqrt(2.0), kQf);
    sum += std::pow(ColourDifference(seen_a[i], seen_b[i]), 1 - std::min(feature, 1.0));
  }
  return sum / static_cast<double>(seen_a.size());
}

}  // namespace gonio
