// SPDX-License-Identifier: Apache-2.0
#include "drivers/grbl_legs.h"

#include <algorithm>
#include <cmath>

namespace gonio::grbl {
namespace {

constexpr double kTogether = 0.05;  // s

double TimeOf(const Way& way) { return std::abs(way.to - way.from) / way.speed; }

// When legs end [s], first to last.
std::vector<double> EndsOf(const std::vector<Way>& ways) {
  std::vector<double> times;
  for (const Way& way : ways) {
    if (TimeOf(way) > 0) times.push_back(TimeOf(way));
  }
  std::sort(times.begin(), times.end());
  std::vector<double> ends;
  for (std::size_t i = 0; i < times.size(); ++i) {
    const bool last = i + 1 == times.size();
    if (last || times[i + 1] - times[i] > kTogether) ends.push_back(times[i]);
  }
  return ends;
}

}  // namespace

std::vector<Leg> LegsOf(const std::vector<Way>& ways) {
  std::vector<Leg> legs;
  double begin = 0;
  for (const double end : EndsOf(ways)) {
    Leg leg;
    double squares = 0;
    for (const Way& way : ways) {
      const double time = TimeOf(way);
      if (time <= begin) continue;
      const auto at = [&](double t) {
        return t >= time ? way.to : way.from + (way.to - way.from) * t / time;
      };
      leg.target[static_cast<std::size_t>(way.axis)] = at(end);
      squares += (at(end) - at(begin)) * (at(end) - at(begin));
    }
    leg.feed = 60 * std::sqrt(squares) / (end - begin);
    legs.push_back(leg);
    begin = end;
  }
  return legs;
}

}  // namespace gonio::grbl
