// SPDX-License-Identifier: Apache-2.0
// Measured samples as CSV, for people, spreadsheets and other people's instruments.

#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "brdf/brdf.h"

namespace gonio {

struct MeasuredSample {
  int pose = 0;  // number of the pose in its session; a pose may give several samples
  BrdfSample sample;
  double time_s = 0;  // since the session started
};

// Standard uncertainty [1/sr] taken where a file has no sigma column: 2 % of |f_r|, the middle of
// the 1.3 to 4 % seen on real instruments, plus 1e-4, well below what a black sample reflects.
inline constexpr double kDefaultRelativeSigma = 0.02;
inline constexpr double kDefaultSigmaFloor = 1e-4;

// A file has comment lines starting with '#', one header row, and a row for each sample:
//
//   column                             unit   when reading
//   pose                               -      whole number; optional, default: 0, 1, 2, ...
//   theta_i_deg, theta_o_deg           deg    -90 < theta < 90, from the normal; a negative one is
//                                             on the other side: as positive, with phi + 180
//   phi_i_deg, phi_o_deg               deg    any finite angle
//   phi_deg                            deg    in place of both: azimuth from light to detector,
//                                             0 where they are on the same side of the normal
//   theta_h_deg, theta_d_deg, phi_d_deg deg   in place of all of these, which they follow from;
//                                             ignored where theta_i is there
//   f_r_red, f_r_green, f_r_blue       1/sr   required, without cosine; negative is kept
//   f_r                                1/sr   in place of the three: one channel, which counts for
//                                             all of them as a mono pixel does
//   sigma_red, sigma_green, sigma_blue 1/sr   > 0, or inf: this channel is unusable; optional,
//                                             default as above
//   sigma                              1/sr   in place of the three
//   time_s                             s      optional, default 0
//
// Angles may be radians: theta_i_rad, .... Columns may stand in any order; unknown ones are
// ignored. Directions at or below the horizon are refused: what is measured there is no
// reflectance. Rows with the same directions are samples of their own. Cells may be quoted and
// padded with blanks, lines may end in CR LF, and a byte order mark is skipped, as spreadsheets
// like it.
//
// Throws ConfigError "samples.csv:12: column f_r_red: is "abc", must be a finite number", and
// likewise on a missing or repeated column, two for the same, a ragged row, a direction below the
// horizon, or a file without samples.
std::vector<MeasuredSample> ReadSamplesCsv(const std::filesystem::path& path);
// `name` stands for the file in messages.
std::vector<MeasuredSample> ParseSamplesCsv(const std::string& text, const std::string& name);

// Writes pose, the angles in degrees without phi_deg, three channels and time_s, numbers with all
// the digits it takes to read them back exactly (the directions, being angles in the file, come
// back to rounding). `comments` are put on top, one '#' line each. An f_r that is not finite is
// written as 0 if its sigma is infinite; otherwise f_r must be finite (precondition). Throws
// std::runtime_error.
void WriteSamplesCsv(const std::filesystem::path& path, const std::vector<MeasuredSample>& samples,
                     const std::vector<std::string>& comments = {});

}  // namespace gonio
