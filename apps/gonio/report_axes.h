// SPDX-License-Identifier: Apache-2.0
// What the pictures of a report have in common: colours and axes, as gnuplot wants them.

#pragma once

#include <string>

#include "brdf/brdf.h"

namespace gonio {

// Vermilion, bluish green and blue of Okabe and Ito's palette: red, green and blue to everybody,
// the colour-blind included.
inline constexpr const char* kChannelColours[kChannels] = {"#d55e00", "#009e73", "#0072b2"};

// theta_h is drawn as MERL spaces it, by its square root: the highlight is narrow. The number to
// plot for theta_h [rad], and the axis that goes with it.
double SqrtDeg(double theta_h);
std::string ThetaHAxis();

// What a logarithmic axis must show. Numbers that it cannot are ignored.
class LogRange {
 public:
  void Include(double number);
  // `axis`: x or y. Adds a margin by the factor `margin`; labels 1, 2, 5, 10, ... or, over more
  // than three decades, powers of ten.
  std::string Axis(char axis, double margin) const;

 private:
  double min_ = 0;  // 0: nothing yet
  double max_ = 0;
};

}  // namespace gonio
