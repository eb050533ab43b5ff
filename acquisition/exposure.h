// SPDX-License-Identifier: Apache-2.0
// How long to expose: few frames, none of them wasted.

#pragma once

#include <optional>
#include <span>
#include <vector>

#include "acquisition/frame_taker.h"
#include "acquisition/image_regions.h"
#include "acquisition/rig.h"

namespace gonio {

// Means over those pixels of a frame that see a region, per channel. A pixel without colour counts
// for all three, or for that of the light alone.
struct FrameMeans {
  Rgb counts = Rgb::Zero();              // above the black level; negative at low light
  Rgb saturated_fraction = Rgb::Zero();  // of the pixels, at full scale: 0 .. 1
  Rgb pixels = Rgb::Zero();              // how many; zero leaves the others zero
};
FrameMeans MeansOf(const Frame& frame, int full_scale, std::span<const ImageRegion> regions,
                   const std::optional<LightColour>& colour = std::nullopt);

// Counts per second and pixel that a sample of f_r gives under so much light (docs/radiometry.md).
Rgb CountRates(const Rgb& f_r, double cos_theta_i, double light,
               const RadiometryConfig& radiometry);

// The exposure that brings the brightest channel to the target fraction of full scale, inside the
// camera's range and the soft limit. `rates`: counts per second and pixel that are expected; zero
// or not finite gives the soft limit.
Seconds FirstExposure(const Rgb& rates, const RigConfig& rig);

// The exposure to take after `taken` (not empty), or empty when every channel is either good
// (unsaturated and above min_fraction in some frame) or cannot be made so. In this order:
//
//   1. A channel saturated in every frame: shorter, by 2 if only some pixels were, by 4 if another
//      channel was not, by 16 otherwise.
//   2. The brightest channel that is not good yet: longer, to its target.
//
// Every frame stays in the record: a channel is masked only in the frames that saturate it.
// Channels that no frame shows are of no concern: of a light with colours `taken` is what was
// taken in one of them.
std::optional<Seconds> NextExposure(std::span<const Exposure> taken,
                                    std::span<const ImageRegion> regions, const RigConfig& rig);

// Counts per second and pixel of a channel, by the longest frame that did not saturate it. Empty:
// there is none.
std::optional<double> RateOf(std::span<const Exposure> taken, std::span<const ImageRegion> regions,
                             int channel, const RigConfig& rig);

}  // namespace gonio
