// SPDX-License-Identifier: Apache-2.0
// A sphere of one material, as the papers of the field show it.

#pragma once

#include "brdf/brdf.h"
#include "brdf/render/environment.h"
#include "brdf/render/image.h"

namespace gonio {

// The camera looks along -z from far away (orthographic), x to the right, y up; the sphere fills
// the image but for a margin. Outside it, and where the reflectance is unknown, pixels are black.
struct RenderOptions {
  int size = 256;       // pixels, both ways; 16 .. 4096
  int samples = 256;    // directions of light per pixel under an environment; 1 .. 65536
  int supersample = 3;  // sub-pixels both ways, 1 .. 16
  int threads = 1;      // >= 1; the image is the same to the last bit for any number

  // Throws ConfigError naming the option.
  void Check() const;
};

// Under one distant light of irradiance pi on a surface that faces it: a white Lambertian sphere is
// 1 at its brightest. `light` is a unit vector towards it; the default is up and left of the
// camera.
Image RenderUnderPoint(const Brdf& brdf, const RenderOptions& options,
                       const Eigen::Vector3d& light = Eigen::Vector3d(-0.4, 0.5, 0.7681146));

// Under an environment, by multiple importance sampling of light, half vector and cosine (Veach &
// Guibas, SIGGRAPH 1995). Deterministic.
Image RenderUnder(const Brdf& brdf, const Environment& environment, const RenderOptions& options);

}  // namespace gonio
