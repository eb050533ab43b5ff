// SPDX-License-Identifier: Apache-2.0
// Spectral measurements of Cornell University's gonioreflectometer (Foo, "A Gonioreflectometer for
// Measuring the Bidirectional Reflectance of Material for Use in Illumination Computation",
// Master's thesis, 1997), .brdf.

#pragma once

#include <array>
#include <string>
#include <vector>

#include "brdf/samples_csv.h"

namespace gonio {

// Wavelengths [nm] that make a channel, ends included.
struct WavelengthBand {
  double from_nm = 0;
  double to_nm = 0;
};
using WavelengthBands = std::array<WavelengthBand, kChannels>;  // red, green, blue
// Roughly what a colour camera tells apart; below 440 nm the instrument is noisy.
inline constexpr WavelengthBands kColourBands = {{{600, 700}, {500, 590}, {440, 490}}};

// Standard uncertainty [1/sr] that is taken for a value, as the files have none: 2 % of it plus
// this, over cos(theta_i). Values with light and detector exchanged differ by 0.001 to 0.005 over
// cos(theta_i), as if too much background had been taken off, and what would be negative then is
// exactly zero.
inline constexpr double kCornellFloor = 2e-3;

struct CornellBrdf {
  std::string title;  // comments before the first number, in one line
  std::vector<double> wavelengths_nm;
  std::vector<MeasuredSample> samples;  // means over the bands, each a pose of its own; no times
  int zeros = 0;                        // channels of samples where every value was exactly zero
};

// Text, whose lines may end in CR LF, '#' beginning a comment anywhere: the number of wavelengths,
// the wavelengths [nm] on as many lines as they take, then a line for each pair of directions:
//
//   theta_i phi_i theta_s phi_s  f_r at each wavelength
//
// in radians, -pi/2 < theta < pi/2, equal azimuths on the same side; f_r [1/sr] without cosine.
//
// Throws ConfigError "FILE:14: number 3 (theta_s): is "1.6", must be ...", and likewise, also if a
// band holds no wavelength of the file.
CornellBrdf ParseCornell(const std::string& text, const std::string& name,
                         const WavelengthBands& bands = kColourBands);

}  // namespace gonio
