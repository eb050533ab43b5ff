// SPDX-License-Identifier: Apache-2.0
// How different two renders look.

#pragma once

#include "brdf/render/image.h"

namespace gonio {

// Both images are linear and are shown at the same `exposure` (brdf/render/image.h).
struct ImageDifference {
  double delta_e_itp = 0;  // mean over pixels; 1: just noticeable (ITU-R BT.2124)
  double psnr_db = 0;      // of the sRGB code values; +inf for equal images
  double ssim = 0;  // mean over pixels and colours; 1 for equal images (Wang et al., IEEE TIP
                    // 13(4), 2004)
  double flip = 0;  // mean, 0 .. 1 (Andersson et al., "FLIP", HPG 2020)
};

// Precondition: same size, at least 11 x 11 pixels.
ImageDifference CompareImages(const Image& reference, const Image& other, double exposure);

// The parts, each checked against published or independently computed values in the tests. Images
// here are sRGB code values 0 .. 1, but for DeltaEItp: linear Rec. 709 in cd/m^2.
double Psnr(const Image& reference, const Image& other);
double Ssim(const Image& reference, const Image& other);
// `pixels_per_degree`: of the visual field; 67 is FLIP's own default (0.7 m from a 0.7 m wide 4K
// screen).
double Flip(const Image& reference, const Image& other, double pixels_per_degree = 67.0206);
double DeltaEItp(const Image& reference, const Image& other);
// Of two colours in ICtCp.
double DeltaEItp(const Eigen::Array3d& a, const Eigen::Array3d& b);
// ICtCp of a linear colour in cd/m^2, with Rec. 709 or Rec. 2020 primaries (ITU-R BT.2087, BT.2100
// with PQ); clipped to 0 .. 10,000 cd/m^2.
Eigen::Array3d IctcpOf(const Eigen::Array3d& rec709);
Eigen::Array3d IctcpOfRec2020(const Eigen::Array3d& rec2020);

}  // namespace gonio
