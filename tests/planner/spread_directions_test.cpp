// SPDX-License-Identifier: Apache-2.0
#include "planner/spread_directions.h"

#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "core/units.h"

namespace gonio {
namespace {

TEST(SpreadDirections, StayAboveTheLimitAndWeighOneTogether) {
  double sum = 0;
  for (const SpreadDirection& at : SpreadDirections(500, RadFromDeg(80))) {
    double cos_i = 0;
    double cos_o = 0;
    Cosines(at.angles, &cos_i, &cos_o);
    EXPECT_EQ(at.cosine, cos_i);
    EXPECT_GE(std::min(cos_i, cos_o), std::cos(RadFromDeg(80)));
    sum += at.weight;
  }
  EXPECT_NEAR(sum, 1, 1e-12);
}

TEST(SpreadDirections, AreEvenInTheHighlightAlone) {
  // Within 2 degrees of the mirror direction, in ninths of theta_d below 80 deg x thirds of phi_d.
  std::set<int> cells;
  for (const SpreadDirection& at : SpreadDirections(1200, RadFromDeg(80))) {
    if (at.angles.theta_h > RadFromDeg(2)) continue;
    const int d = static_cast<int>(9 * at.angles.theta_d / RadFromDeg(80));
    const int p = static_cast<int>(3 * at.angles.phi_d / kPi);
    cells.insert(3 * d + p);
  }
  EXPECT_GE(cells.size(), 24u);
}

}  // namespace
}  // namespace gonio
