// SPDX-License-Identifier: Apache-2.0
// Which pixels of an image see the sample, and from where.

#pragma once

#include <cstdint>
#include <vector>

#include "acquisition/rig.h"
#include "brdf/imaging.h"

namespace gonio {

// Pixels that are averaged into one sample, because they see it under nearly the same directions.
struct ImageRegion {
  // Means over the pixels, in the frame of the surface they see: its z along the normal, its x the
  // sample's x laid on the surface.
  DirectionPair directions;
  std::vector<std::uint32_t> pixels;  // row * width + column, ascending
  // Of each pixel: cos(theta_i) (d_L / |L - p|)^2, by which the point p that it sees is lit less
  // than one at the origin whose normal points at the light L, d_L away. Empty: `light` of all.
  std::vector<float> lights;
  double light = 0;  // mean of `lights`
};

// The regions of an image of width by height pixels, as `imaging` has it, with the arms where they
// are (docs/radiometry.md, "Which pixels").
//
// Without a focal length that is one region of all pixels, which see what the arms say. Otherwise
// those that see the patch, lit and at a polar angle below `max_polar` on both sides, in `count`
// parts of nearly equal size: halved again and again where the half vector or theta_d spreads
// most. `count` is a power of two. The first is the one that is nearest to the directions of the
// arms. Empty if no pixel is left; fewer if there are too few pixels.
std::vector<ImageRegion> RegionsOf(const Imaging& imaging, const ArmAngles& arms, int width,
                                   int height, double max_polar, int count = 1);

// Takes the pixels away of which some site is marked (SiteMask of all sites, with `per_pixel` of
// each), and regions of which nothing is left. Directions stay: bad pixels are few.
void LeaveOut(const std::vector<std::uint8_t>& marked, int per_pixel,
              std::vector<ImageRegion>* regions);

}  // namespace gonio
