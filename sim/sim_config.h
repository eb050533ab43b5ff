// SPDX-License-Identifier: Apache-2.0
// The truth about a simulated rig, which its configuration only believes to know.

#pragma once

#include "brdf/brdf.h"
#include "core/config.h"

namespace gonio {

// Every imperfection is one number, and zero (or false) switches it off: with all of them off the
// rig is exact to the camera's rounding.
struct SimConfig {
  double encoder_resolution = 0;    // rad, readings are multiples of it
  double repeatability = 0;         // rad, standard deviation of where a move truly ends
  double light_drift_per_hour = 0;  // relative slope of the light's power when it is switched on
  double monitor_noise = 0;         // relative standard deviation of one reading
  double multiplicative_noise = 0;  // relative standard deviation of a channel's gain per frame
  double read_noise = 0;            // electrons rms, per pixel and frame
  double dark_current = 0;          // electrons per second per pixel
  bool shot_noise = false;          // electrons arrive by Poisson's law
  int black_level = 0;              // counts; too low and read noise is clipped at zero
  // Electrons a pixel holds; more are lost. 0: deeper than full scale. Where it is shallower,
  // frames saturate below the full scale that the rig looks for, and only the rig's
  // full_scale_counts can tell it.
  double full_well = 0;

  // No imperfections, but what the rig's `radiometry` should agree with.
  Rgb responsivity = Rgb::Ones();  // electrons per pixel and second at f_r cos(theta_i) = 1/sr
  double electrons_per_count = 1;
};

// Reads the `simulation` mapping of a rig file. Noises, responsivity and electrons_per_count that
// it leaves out are what `radiometry` believes. Throws ConfigError.
SimConfig ReadSim(const ConfigNode& root);

}  // namespace gonio
