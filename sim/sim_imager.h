// SPDX-License-Identifier: Apache-2.0
// A simulated camera's lens and sensor, without time and without a machine: for whoever knows where
// the arms point and how bright the lamp is.

#pragma once

#include "brdf/brdf.h"
#include "brdf/imaging.h"
#include "drivers/camera.h"
#include "sim/sim_optics.h"
#include "sim/sim_sensor.h"

namespace gonio {

// All that one frame depends on beside the sample and chance.
struct SimView {
  SimArms arms{};              // rad, true: with SimConfig::axis_offset, if there is one
  double power = 1;            // of the lamp, relative to full power; 0: a dark frame
  Rgb spectrum = Rgb::Ones();  // as SpectrumOf() in sim_light.h; all 1: white
  SimReadout readout{};
};

// SimOptics and SimSensor, one behind the other. A reference standard instead of the sample is
// another Brdf. One thread; the same calls give the same frames.
//
//   SimImager imager(truth, imaging, 512, 512, Random(seed, stream));
//   Frame frame = imager.Expose({.arms = arms, .power = 1,
//                                .readout = {.exposure = Seconds(0.1), .black_level = 64}},
//                                sample);
class SimImager {
 public:
  // The sensor's size in pixels; its middle looks at the origin. Where `imaging` resolves no
  // directions all pixels see the arms' pair.
  SimImager(const SimConfig& truth, const Imaging& imaging, int sensor_width, int sensor_height,
            Random random);

  // Where the sample's reflectance is unknown pixels are dark: refuse before, as SimCamera does.
  Frame Expose(const SimView& view, const Brdf& sample);

  // The two halves, for exposures during which something changes: rates [electrons/s] without
  // noise, and what a sensor makes of electrons.
  SimImage See(const SimView& view, const Brdf& sample);
  Frame Read(const SimImage& electrons, const SimReadout& readout);

  // The temporal noise comes from `random` from now on.
  void Reseed(Random random) { sensor_.Reseed(random); }

 private:
  SimOptics optics_;
  SimSensor sensor_;
};

}  // namespace gonio
