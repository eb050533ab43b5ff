// SPDX-License-Identifier: Apache-2.0
#include "brdf/render/image_metrics.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "core/check.h"

namespace gonio {
namespace {

// Perceptual quantiser of SMPTE ST 2084: cd/m^2 to a code of 0 .. 1.
double Pq(double luminance) {
  constexpr double kM1 = 2610.0 / 16384, kM2 = 2523.0 / 4096 * 128;
  constexpr double kC1 = 3424.0 / 4096, kC2 = 2413.0 / 4096 * 32, kC3 = 2392.0 / 4096 * 32;
  const double y = std::pow(std::clamp(luminance / 10000, 0.0, 1.0), kM1);
  return std::pow((kC1 + kC2 * y) / (1 + kC3 * y), kM2);
}

void RequireSameSize(const Image& a, const Image& b) {
  GONIO_CHECK(a.width == b.width && a.height == b.height, "images of the same size");
}

cv::Mat Plane(const Image& image, int channel) {
  cv::Mat plane(image.height, image.width, CV_64F);
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) plane.at<double>(y, x) = image.at(x, y)[channel];
  }
  return plane;
}

constexpr int kSsimRadius = 5;

cv::Mat Blurred(const cv::Mat& image) {
  cv::Mat result;
  constexpr int kWidth = 2 * kSsimRadius + 1;
  cv::GaussianBlur(image, result, {kWidth, kWidth}, 1.5, 1.5, cv::BORDER_REFLECT);
  return result;
}

// Mean over the pixels whose window lies inside the image.
double SsimOfPlane(const cv::Mat& a, const cv::Mat& b) {
  constexpr double kC1 = 0.01 * 0.01, kC2 = 0.03 * 0.03;
  const cv::Mat mean_a = Blurred(a);
  const cv::Mat mean_b = Blurred(b);
  const cv::Mat var_a = Blurred(a.mul(a)) - mean_a.mul(mean_a);
  const cv::Mat var_b = Blurred(b.mul(b)) - mean_b.mul(mean_b);
  const cv::Mat covariance = Blurred(a.mul(b)) - mean_a.mul(mean_b);
  const cv::Mat upper = (2 * mean_a.mul(mean_b) + kC1).mul(2 * covariance + kC2);
  const cv::Mat lower = (mean_a.mul(mean_a) + mean_b.mul(mean_b) + kC1).mul(var_a + var_b + kC2);
  const cv::Mat ssim = upper / lower;
  const cv::Rect inside(kSsimRadius, kSsimRadius, a.cols - 2 * kSsimRadius,
                        a.rows - 2 * kSsimRadius);
  return cv::mean(ssim(inside))[0];
}

Image Scaled(const Image& image, double factor) {
  Image scaled = image;
  for (Eigen::Array3f& pixel : scaled.pixels) pixel *= static_cast<float>(factor);
  return scaled;
}

}  // namespace

Eigen::Array3d IctcpOf(const Eigen::Array3d& rec709) {
  // ITU-R BT.2087 to the primaries of BT.2020, then BT.2100's LMS and ICtCp.
  static const Eigen::Matrix3d rec2020_from_rec709 =
      (Eigen::Matrix3d() << 0.6274, 0.3293, 0.0433, 0.0691, 0.9195, 0.0114, 0.0164, 0.0880, 0.8956)
          .finished();
  return IctcpOfRec2020((rec2020_from_rec709 * rec709.matrix()).array());
}

Eigen::Array3d IctcpOfRec2020(const Eigen::Array3d& rec2020) {
  static const Eigen::Matrix3d lms_from_rgb =
      (Eigen::Matrix3d() << 1688, 2146, 262, 683, 2951, 462, 99, 309, 3688).finished() / 4096;
  static const Eigen::Matrix3d ictcp_from_lms =
      (Eigen::Matrix3d() << 2048, 2048, 0, 6610, -13613, 7003, 17933, -17390, -543).finished() /
      4096;
  const Eigen::Vector3d lms = lms_from_rgb * rec2020.matrix();
  return (ictcp_from_lms * lms.unaryExpr(&Pq)).array();
}

double DeltaEItp(const Eigen::Array3d& a, const Eigen::Array3d& b) {
  const Eigen::Array3d d = a - b;
  return 720 * std::sqrt(d[0] * d[0] + 0.25 * d[1] * d[1] + d[2] * d[2]);  // T = Ct / 2
}

double DeltaEItp(const Image& reference, const Image& other) {
  RequireSameSize(reference, other);
  double sum = 0;
  for (std::size_t i = 0; i < reference.pixels.size(); ++i) {
    sum += DeltaEItp(IctcpOf(reference.pixels[i].cast<double>()),
                     IctcpOf(other.pixels[i].cast<double>()));
  }
  return sum / static_cast<double>(reference.pixels.size());
}

double Psnr(const Image& reference, const Image& other) {
  RequireSameSize(reference, other);
  double sum = 0;
  for (std::size_t i = 0; i < reference.pixels.size(); ++i) {
    sum += (reference.pixels[i] - other.pixels[i]).cast<double>().square().mean();
  }
  if (sum == 0) return std::numeric_limits<double>::infinity();
  return -10 * std::log10(sum / static_cast<double>(reference.pixels.size()));
}

double Ssim(const Image& reference, const Image& other) {
  RequireSameSize(reference, other);
  GONIO_CHECK(reference.width > 2 * kSsimRadius && reference.height > 2 * kSsimRadius,
              "larger than the window");
  double sum = 0;
  for (int c = 0; c < 3; ++c) sum += SsimOfPlane(Plane(reference, c), Plane(other, c));
  return sum / 3;
}

ImageDifference CompareImages(const Image& reference, const Image& other, double exposure) {
  // Where a display of 203 cd/m^2 shows white (ITU-R BT.2408), highlights going on beyond it.
  constexpr double kWhiteLuminance = 203;
  const Image shown_reference = ToneMap(reference, exposure);
  const Image shown_other = ToneMap(other, exposure);
  ImageDifference difference;
  difference.delta_e_itp = DeltaEItp(Scaled(reference, exposure * kWhiteLuminance),
                                     Scaled(other, exposure * kWhiteLuminance));
  difference.psnr_db = Psnr(shown_reference, shown_other);
  difference.ssim = Ssim(shown_reference, shown_other);
  difference.flip = Flip(shown_reference, shown_other);
  return difference;
}

}  // namespace gonio
