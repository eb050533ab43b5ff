// SPDX-License-Identifier: Apache-2.0
// Each measure against values that were published or computed by others' programs.
#include "brdf/render/image_metrics.h"

#include <gtest/gtest.h>

#include <cmath>

namespace gonio {
namespace {

Image Uniform(float r, float g, float b) {
  Image image(32, 32);
  for (Eigen::Array3f& pixel : image.pixels) pixel = {r, g, b};
  return image;
}

// The pattern whose values below were computed in Python, in single precision.
Image Waves(double phase) {
  Image image(64, 48);
  for (int y = 0; y < image.height; ++y) {
    for (int x = 0; x < image.width; ++x) {
      for (int c = 0; c < 3; ++c) {
        image.at(x, y)[c] = static_cast<float>(
            0.5 + 0.4 * std::sin(0.3 * x + 0.2 * y * (c + 1) + phase) * std::cos(0.15 * y + c));
      }
    }
  }
  return image;
}

TEST(ImageMetrics, FindNoDifferenceBetweenEqualImages) {
  const Image image = Waves(0);
  EXPECT_EQ(DeltaEItp(image, image), 0);
  EXPECT_TRUE(std::isinf(Psnr(image, image)));
  EXPECT_NEAR(Ssim(image, image), 1, 1e-12);
  EXPECT_EQ(Flip(image, image), 0);
}

TEST(Psnr, IsThatOfAKnownOffset) {
  EXPECT_NEAR(Psnr(Uniform(0.2f, 0.2f, 0.2f), Uniform(0.3f, 0.3f, 0.3f)), 20, 1e-5);
  EXPECT_NEAR(Psnr(Waves(0), Waves(0.35)), 23.1691065988, 1e-5);  // NumPy
}

TEST(Ssim, IsThatOfScikitImage) {
  // skimage.metrics.structural_similarity(gaussian_weights=True, sigma=1.5,
  // use_sample_covariance=False, data_range=1, channel_axis=2), scikit-image 0.19.
  EXPECT_NEAR(Ssim(Waves(0), Waves(0.35)), 0.92261726, 2e-6);
}

TEST(Ssim, IsAClosedFormForUniformImages) {
  const double a = 0.2f;
  const double b = 0.6f;
  EXPECT_NEAR(Ssim(Uniform(0.2f, 0.2f, 0.2f), Uniform(0.6f, 0.6f, 0.6f)),
              (2 * a * b + 1e-4) / (a * a + b * b + 1e-4), 1e-6);
}

TEST(DeltaEItp, IsThatOfPublishedColours) {
  // Examples in the documentation of the Python package colour-science.
  const Eigen::Array3d ictcp = IctcpOfRec2020({0.45620519, 0.03081071, 0.04091952});
  EXPECT_NEAR(ictcp[0], 0.07351364, 1e-7);
  EXPECT_NEAR(ictcp[1], 0.00475253, 1e-7);
  EXPECT_NEAR(ictcp[2], 0.09351596, 1e-7);
  EXPECT_NEAR(DeltaEItp(Eigen::Array3d(0.4885468072, -0.04739350675, 0.07475401302),
                        Eigen::Array3d(0.4899203231, -0.04567508203, 0.07361341775)),
              1.42657228, 1e-7);
}

TEST(DeltaEItp, OfGreysIsThatOfTheQuantiser) {
  // SMPTE ST 2084: 100 cd/m^2 is 50.81 % of the range, 203 cd/m^2 58.07 % (ITU-R BT.2408).
  const Eigen::Array3d grey = IctcpOf(Eigen::Array3d::Constant(203));
  EXPECT_NEAR(grey[0], 0.5807, 1e-4);
  EXPECT_NEAR(grey[1], 0, 1e-4);
  EXPECT_NEAR(grey[2], 0, 1e-4);
  EXPECT_NEAR(DeltaEItp(Uniform(203, 203, 203), Uniform(100, 100, 100)), 720 * (0.58069 - 0.50808),
              0.05);
}

TEST(Flip, OfUniformImagesIsTheColourDifferenceAlone) {
  const Image black = Uniform(0, 0, 0);
  const Image white = Uniform(1, 1, 1);
  // |L* 100|^0.7 = 25.12 beyond the bend at 0.4 x 41.27: 0.95 + 0.05 x 8.61 / 24.76.
  EXPECT_NEAR(Flip(black, white), 0.9673798, 1e-6);
  EXPECT_NEAR(Flip(white, black), 0.9673798, 1e-6);
  // Green against blue is what differences are scaled by.
  EXPECT_NEAR(Flip(Uniform(0, 1, 0), Uniform(0, 0, 1)), 1, 1e-9);
}

TEST(Flip, AgreesWithAnIndependentProgram) {
  // A NumPy program written from the paper's formulas.
  EXPECT_NEAR(Flip(Waves(0), Waves(0.35)), 0.3204669353, 1e-6);
  Image flat(40, 40);
  for (Eigen::Array3f& pixel : flat.pixels) pixel.setConstant(0.2f);
  Image edge = flat;
  for (int y = 0; y < 40; ++y) {
    for (int x = 20; x < 40; ++x) edge.at(x, y).setConstant(0.8f);
  }
  EXPECT_NEAR(Flip(flat, edge), 0.5246245487, 1e-6);
}

TEST(CompareImages, ShowsBothAtTheSameExposure) {
  const ImageDifference d = CompareImages(Uniform(2, 2, 2), Uniform(1, 1, 1), 0.5);
  // Codes 1 and 0.7354 (sRGB of 0.5).
  EXPECT_NEAR(d.psnr_db, -20 * std::log10(1 - 0.735357), 1e-3);
  EXPECT_NEAR(d.delta_e_itp,
              720 * (IctcpOf(Eigen::Array3d::Constant(203))[0] -
                     IctcpOf(Eigen::Array3d::Constant(101.5))[0]),
              1e-3);
}

}  // namespace
}  // namespace gonio
