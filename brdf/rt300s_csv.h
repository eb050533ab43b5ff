// SPDX-License-Identifier: Apache-2.0
// Sessions of an RT-300S goniophotometer (J & C Technology) that were saved as CSV.

#pragma once

#include <string>
#include <vector>

#include "brdf/samples_csv.h"

namespace gonio {

// Standard uncertainty [1/sr] that is taken for a reading, as the files have none: 2 % of it plus
// this. Readings without a sample go from -0.0018 to 0.0051 with the receiver's angle, whatever the
// incidence: 0.0020 rms.
inline constexpr double kRt300sFloor = 2e-3;

struct Rt300sSession {
  std::string started;  // by the instrument's clock, "2011-02-13T11:07:15"; in no known time zone
  std::vector<MeasuredSample> samples;  // in the order of the file, each a pose of its own
};

// Columns that are read; others (sheet, method, RT_per_nm, spec380, ...) are ignored:
//
//   clock          -    "2011-02-13T11:07:15"; to whole seconds
//   incidence_deg  deg  of the light, from the normal; -90 < angle < 90
//   receive_deg    deg  of the receiver, from the normal, in its plane; -90 < angle < 90
//   azimuth_deg    deg  of the receiver's plane: at -90 it is the plane of incidence and positive
//                       angles are on the mirror's side, at +90 negative ones are
//   RT             1/sr negative ones are kept
//
// No description of the files came with them. That RT is f_r cos(theta_o) follows from reciprocity:
// with incidence and receiver exchanged, readings of a rough black coating in the plane of
// incidence differ by the ratio of the receivers' cosines, to a tenth over a range of 2.7; f_r
// itself would not differ. So f_r = RT / cos(receive_deg). One channel, which counts for all three.
//
// Throws ConfigError "FILE:12: column RT: is "abc", must be a finite number", and likewise.
Rt300sSession ParseRt300s(const std::string& text, const std::string& name);

// Whether the header of a CSV file is one of these.
bool LooksLikeRt300s(const std::string& text);

}  // namespace gonio
