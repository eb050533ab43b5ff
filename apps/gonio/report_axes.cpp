// SPDX-License-Identifier: Apache-2.0
#include "apps/gonio/report_axes.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/units.h"

namespace gonio {

double SqrtDeg(double theta_h) { return std::sqrt(DegFromRad(theta_h)); }

std::string ThetaHAxis() {
  std::string tics;
  for (const int deg : {0, 1, 5, 10, 20, 30, 45, 60, 75, 90}) {
    tics += fmt::format("{}'{}' sqrt({})", tics.empty() ? "" : ", ", deg, deg);
  }
  return "set xrange [0:sqrt(90)]\nset xtics (" + tics +
         ")\nset xlabel 'half angle {/:Italic θ}_h [deg], square-root scale'\n";
}

void LogRange::Include(double number) {
  if (!(number > 0) || !std::isfinite(number)) return;
  min_ = min_ > 0 ? std::min(min_, number) : number;
  max_ = std::max(max_, number);
}

std::string LogRange::Axis(char axis, double margin) const {
  const double min = (min_ > 0 ? min_ : 0.1) / margin;
  const double max = (min_ > 0 ? max_ : 1) * margin;
  const bool few_decades = max < 1000 * min;
  std::string tics;
  const int first = static_cast<int>(std::floor(std::log10(min)));
  for (int decade = first; std::pow(10, decade) <= max; ++decade) {
    for (const int mantissa : {1, 2, 5}) {
      const double at = mantissa * std::pow(10, decade);
      if (at < min || at > max || (mantissa != 1 && !few_decades)) continue;
      const std::string label =
          few_decades ? fmt::format("{:.6g}", at) : fmt::format("10^{{{}}}", decade);
      tics += fmt::format("{}'{}' {:.6g}", tics.empty() ? "" : ", ", label, at);
    }
  }
  return fmt::format("set logscale {0}\nset {0}range [{1:.6g}:{2:.6g}]\nset {0}tics ({3})\n", axis,
                     min, max, tics);
}

}  // namespace gonio
