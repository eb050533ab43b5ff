// SPDX-License-Identifier: Apache-2.0
// The responsivity of the instrument, from a standard whose f_r is known.
//
// A merged rate [electrons/s at light 1] over a region, per unit of light (region_statistics.h), is
// s = R f_r. With f_r from a certificate, R = s / f_r, and relative variances add (GUM 5.1.6):
// those of the certificate, of s and of whatever the caller adds (monitor, alignment). Typical
// standards are sintered PTFE, f_r near 0.31 / sr at 0:45, 1 % (k = 1) at best; it is not
// Lambertian: off 0:45 by several per cent beyond 60 degrees (Hoepe and Hauer, Metrologia 47,
// 2010).

#pragma once

#include <array>
#include <filesystem>
#include <string>
#include <vector>

#include "acquisition/radiometry/measured_value.h"
#include "brdf/brdf.h"
#include "core/error.h"

namespace gonio {

// f_r of a standard in the plane of incidence: theta_o is > 0 on the side of the mirror direction
// and < 0 on the light's side, both from the normal.
struct StandardPoint {
  double theta_i = 0;       // rad, >= 0
  double theta_o = 0;       // rad
  Rgb f_r = Rgb::Zero();    // 1/sr, > 0
  Rgb sigma = Rgb::Zero();  // 1/sr, standard uncertainty (k = 1)
};

// A YAML file:
//
//   format: gonio-reference-standard
//   version: 1
//   name: PTFE tile 17, certificate 2024-031
//   coverage_factor: 2            # of the f_r_uncertainty below; the file's values are divided by
//   it points:
//     - {theta_i_deg: 0, theta_o_deg: 45, f_r: [0.311, 0.312, 0.312], f_r_uncertainty: [0.004,
//     ...]}
class ReferenceStandard {
 public:
  // Throws ConfigError naming file, line and key; angles must be below 90 degrees.
  static ReferenceStandard Load(const std::filesystem::path& path);
  ReferenceStandard(std::string name, std::vector<StandardPoint> points);

  const std::string& name() const { return name_; }
  const std::vector<StandardPoint>& points() const { return points_; }

  // f_r and its sigma for one channel: that of a point within `tolerance` [rad] in both angles.
  // kRefused if there is none: a certificate is not extrapolated.
  Result<MeasuredValue> At(double theta_i, double theta_o, int channel, double tolerance) const;

 private:
  std::string name_;
  std::vector<StandardPoint> points_;
};

// R = s / f_r [electrons/s/(1/sr)] of one channel. `relative_noise`: of what `rate` does not
// include, e.g. the light's long-term drift. kRefused unless rate and f_r are > 0.
Result<MeasuredValue> ResponsivityFrom(const MeasuredValue& rate, const MeasuredValue& f_r,
                                       double relative_noise = 0);

// Several measurements of R (poses of one standard) joined: the weighted mean of the parts that
// differ, plus what they share, the certificate's relative sigma. If they scatter more than their
// sigmas, the mean's is enlarged by sqrt(chi^2 / dof) (Birge, Phys. Rev. 40, 1932). Not empty.
struct JoinedResponsivity {
  MeasuredValue responsivity;
  double chi_squared = 0;
  int degrees_of_freedom = 0;
};
JoinedResponsivity JoinResponsivities(const std::vector<MeasuredValue>& independent,
                                      double shared_relative);

}  // namespace gonio
