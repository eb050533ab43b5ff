// SPDX-License-Identifier: Apache-2.0
#include "sim/sim_imager.h"

namespace gonio {

// Frames of alike pixels keep the numbers that they had before there were images.
SimImager::SimImager(const SimConfig& truth, const Imaging& imaging, int sensor_width,
                     int sensor_height, Random random)
    : optics_(truth, imaging, sensor_width, sensor_height),
      sensor_(truth, sensor_width, sensor_height, random, imaging.resolves_directions()) {}

SimImage SimImager::See(const SimView& view, const Brdf& sample) {
  const SimReadout readout = sensor_.Whole(view.readout);
  const bool mono = readout.layout == PixelLayout::kMono;
  return optics_.Render(view.arms, view.power, sample, readout.region, mono, view.spectrum);
}

Frame SimImager::Read(const SimImage& electrons, const SimReadout& readout) {
  return sensor_.Read(electrons, readout);
}

Frame SimImager::Expose(const SimView& view, const Brdf& sample) {
  SimImage electrons = See(view, sample);
  electrons *= view.readout.exposure.count();
  return Read(electrons, view.readout);
}

}  // namespace gonio
