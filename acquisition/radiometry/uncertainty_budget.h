// SPDX-License-Identifier: Apache-2.0
// The uncertainty of one measured f_r, term by term (JCGM 100:2008, GUM, 5.1.2 and 8).
//
// f_r is a product of powers of the input quantities, so relative variances add:
//
//   u_c^2(f_r) / f_r^2 = sum_i (relative u_i)^2          [GUM 5.1.6, uncorrelated inputs]
//
// for all terms but those that stay when f_r is zero (read noise, rounding, dark, stray light):
// these are absolute, so all terms are kept absolute, in 1/sr. Each is a standard uncertainty. GUM
// knows two ways to evaluate one: A from scatter (read noise), B from anything else (a
// certificate).
//
// What matters to whoever combines measurements is another difference: *random* terms are drawn
// anew for each measurement and average out; *systematic* ones are the same in all that share a
// calibration, and do not. Adding both in squares is right for one sample, wrong for their mean.

#pragma once

#include <array>

#include "brdf/brdf.h"

namespace gonio {

enum class UncertaintyTerm {
  // Random: drawn for each frame or pose.
  kShot,            // photons of signal and dark current
  kRead,            // read noise
  kRounding,        // to whole counts
  kMultiplicative,  // lamp speckle, shutter: common to all pixels of a frame and channel
  kMonitor,         // noise of the light's reading
  // Systematic: the same in all measurements of a session, or until the next calibration.
  kDark,           // of the dark frames that are subtracted
  kFlat,           // flat field over the region
  kLinearity,      // table of corrections
  kExposureRatio,  // told exposure over true exposure
  kStrayLight,     // what was subtracted, or not
  kResponsivity,   // reference standard: its certificate, and its own measurement
  kAngle,          // cos(theta_i), and the slope of f_r, times the error of the directions
  kDrift,          // of the gain since the first visit to the reference; shared by near samples
};
inline constexpr int kUncertaintyTerms = 13;
// "shot", "read", ...: as in reports and files.
const char* ToString(UncertaintyTerm term);
bool IsSystematic(UncertaintyTerm term);

struct UncertaintyBudget {
  std::array<Rgb, kUncertaintyTerms> terms;  // 1/sr, standard uncertainties, >= 0

  UncertaintyBudget() { terms.fill(Rgb::Zero()); }
  Rgb& operator[](UncertaintyTerm term) { return terms[static_cast<std::size_t>(term)]; }
  const Rgb& operator[](UncertaintyTerm term) const {
    return terms[static_cast<std::size_t>(term)];
  }
  Rgb random() const;
  Rgb systematic() const;
  Rgb combined() const;  // u_c: both
};

// Of a mean over `n` independent measurements under one calibration, each with this budget: random
// terms fall as 1 / sqrt(n), systematic ones stay.
UncertaintyBudget BudgetOfMean(const UncertaintyBudget& one, int n);

// Terms that the noise of one exposure contributes, 1/sr, for the mean over the sites of a channel.
struct NoiseInputs {
  double f_r = 0;         // expected, 1/sr; not the noisy result
  double gain_f_r = 0;    // electrons per 1/sr that a site receives: R light M t
  double dark = 0;        // electrons of dark current per site
  double read_noise = 0;  // electrons
  double count = 1;       // electrons/count
  double sites = 1;
  double multiplicative = 0;  // relative
  double monitor = 0;         // relative
};
// Sets the five random terms of one channel.
void SetNoise(const NoiseInputs& inputs, int channel, UncertaintyBudget* budget);

// The angle's term: |d(f_r cos theta_i) / d theta| / cos theta_i * sigma_theta, with `slope` the
// |df_r / dtheta| [1/sr/rad] of the sample and theta_i < pi/2:  sigma * hypot(slope, f_r tan
// theta_i). The two are taken as independent, since encoders of two arms cause them.
double AngleTerm(double f_r, double slope, double theta_i, double sigma_theta);

}  // namespace gonio
