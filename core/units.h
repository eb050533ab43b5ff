// SPDX-License-Identifier: Apache-2.0
// Inside the program: SI and radians. At the borders (YAML, wire, printed text) names carry units.

#pragma once

#include <numbers>

namespace gonio {

inline constexpr double kPi = std::numbers::pi;

constexpr double RadFromDeg(double deg) { return deg * (kPi / 180.0); }
constexpr double DegFromRad(double rad) { return rad * (180.0 / kPi); }

}  // namespace gonio
