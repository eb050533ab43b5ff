// SPDX-License-Identifier: Apache-2.0
// The truth about a simulated rig, which its configuration only believes to know.

#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "brdf/brdf.h"
#include "core/config.h"
#include "sim/sim_geometry.h"
#include "sim/sim_target.h"

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
  double dark_current = 0;          // electrons per second per pixel, at reference_c
  bool shot_noise = false;          // electrons arrive by Poisson's law
  int black_level = 0;              // counts; too low and read noise is clipped at zero
  // Electrons a pixel holds; more are lost. 0: deeper than full scale. Where it is shallower,
  // frames saturate below the full scale that the rig looks for, and only the rig's
  // full_scale_counts can tell it.
  double full_well = 0;

  // The lamp.
  double lamp_flicker = 0;   // relative standard deviation of its power from frame to frame
  double lamp_fails_at = 0;  // s on the session's clock; dark from then on. 0: never
  // Of a light with colours: the part of each that lies in each band beside its own.
  double colour_crosstalk = 0;

  // Relative slope of the responsivity at time zero, which no monitor sees: optics, camera gain,
  // detector temperature. Drifts as the lamp does (SlowDrift).
  double responsivity_drift_per_hour = 0;

  SimRigKind rig = SimRigKind::kFourAxisArms;
  int axes = 4;  // that it has
  // The axes' true positions minus their encoders'.
  SimArms axis_offset{};

  // The image, where the rig's imaging gives each pixel its own directions (sim_optics.h).
  // m, of the light at a finite distance: right and down as in an image, outwards along its arm
  std::array<double, 3> light_offset{};
  double sample_radius = 0;  // m; what lies beyond reflects nothing. 0: endless
  double vignetting = 0;     // times 1 - cos^4 of the field angle is lost; 1: the natural law
  double defocus = 0;        // px, standard deviation of the blur
  double veiling_glare = 0;  // of the frame's mean signal, added to every pixel
  double stray_light = 0;    // electrons/s at full power, added to every pixel, whatever is there
  int every_px = 16;         // f_r is interpolated over at most so many pixels; a power of two

  // How the camera and the distances truly are, where the rig's `imaging` is wrong about them.
  std::optional<double> focal_length = std::nullopt;     // px
  std::optional<double> camera_distance = std::nullopt;  // m
  std::optional<double> light_distance = std::nullopt;   // m
  std::array<double, 2> principal_point{};  // px, to the right of and below the image's middle
  std::array<double, 3> camera_turn{};      // rad, as in Imaging
  double radial_distortion = 0;             // as in Imaging

  // What stands on the stage instead of a sample, if a calibration asks for it.
  SimTarget target{};

  // The axes' motors, of the rig's believed speed and acceleration, and seconds on top of a move.
  SimArms speed_factor{1, 1, 1, 1};
  SimArms acceleration_factor{1, 1, 1, 1};
  SimArms more_overhead{};
  double shutter_offset = 0;  // s, of light that exposures get beyond what the camera tells
  double frame_overhead = 0;  // s, of the camera's read-out, more than is believed

  // The sensor (sim_sensor.h).
  std::uint64_t sensor_seed = 1;  // which specimen: its fixed pattern. The same in every session
  double prnu = 0;                // relative standard deviation of the pixels' responsivities
  double dsnu = 0;                // electrons, standard deviation of the pixels' offsets
  double dark_spread = 0;         // relative standard deviation of the pixels' dark currents
  double hot_pixels = 0;          // fraction of the pixels
  double hot_dark_current = 0;    // electrons per second more, of a hot pixel, at reference_c
  double dark_doubling = 0;       // degrees C that double the dark current; 0: temperature is alike
  double reference_c = 20;        // degrees C
  std::optional<double> temperature_c = std::nullopt;  // of a SimCamera's sensor; else unknown
  double nonlinearity = 0;  // at full scale this fraction of the counts is missing; quadratic

  // No imperfections, but what the rig's `radiometry` should agree with.
  Rgb responsivity = Rgb::Ones();  // electrons per pixel and second at f_r cos(theta_i) = 1/sr
  double electrons_per_count = 1;  // at a gain of 0 dB
};

// Reads the `simulation` mapping of a rig file. Noises, responsivity and electrons_per_count that
// it leaves out are what `radiometry` believes. Throws ConfigError.
SimConfig ReadSim(const ConfigNode& root);

}  // namespace gonio
