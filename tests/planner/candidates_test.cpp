// SPDX-License-Identifier: Apache-2.0
#include "planner/candidates.h"

#include <gtest/gtest.h>

#include <cmath>

#include "brdf/merl_table.h"
#include "core/units.h"

namespace gonio {
namespace {

CandidateOptions Across() { return {.phi = PhiChoice::kAcross}; }

TEST(MakeCandidates, KeepsTheWholeRasterWhenNothingRestrictsIt) {
  for (const PhiChoice phi : {PhiChoice::kAcross, PhiChoice::kSpread}) {
    const std::vector<Candidate> candidates = MakeCandidates({.phi = phi}, {});
    EXPECT_EQ(candidates.size(), 8100u);
    for (const Candidate& candidate : candidates) {
      EXPECT_TRUE(candidate.directions.above_horizon());
    }
  }
}

TEST(MakeCandidates, GoesRowByRow) {
  const std::vector<Candidate> candidates =
      MakeCandidates({.theta_h_count = 5, .theta_d_count = 7}, {});
  ASSERT_EQ(candidates.size(), 35u);
  for (int i = 0; i < 35; ++i) {
    EXPECT_EQ(candidates[i].row, i / 7);
    EXPECT_EQ(candidates[i].column, i % 7);
  }
}

TEST(MakeCandidates, StandsAtTheCellCentresOfAMerlTable) {
  for (const Candidate& candidate : MakeCandidates({}, {})) {
    const HalfDiff cell = MerlTable::CellCentre(candidate.row, candidate.column, 90);
    EXPECT_NEAR(candidate.angles.theta_h, cell.theta_h, 1e-14);
    EXPECT_NEAR(candidate.angles.theta_d, cell.theta_d, 1e-14);
  }
}

TEST(MakeCandidates, SpacesRowsEvenlyIfAsked) {
  const std::vector<Candidate> candidates =
      MakeCandidates({.theta_h_count = 9, .theta_d_count = 1, .merl_spacing = false}, {});
  for (const Candidate& candidate : candidates) {
    EXPECT_NEAR(DegFromRad(candidate.angles.theta_h), 10 * candidate.row + 5, 1e-12);
  }
}

TEST(MakeCandidates, HasDirectionsThatBelongToItsAngles) {
  for (const Candidate& candidate :
       MakeCandidates({.theta_h_count = 20, .theta_d_count = 20}, {})) {
    const HalfDiff angles = ToHalfDiff(candidate.directions);
    EXPECT_NEAR(angles.theta_h, candidate.angles.theta_h, 1e-12);
    EXPECT_NEAR(angles.theta_d, candidate.angles.theta_d, 1e-12);
    EXPECT_NEAR(std::cos(2 * angles.phi_d), std::cos(2 * candidate.angles.phi_d), 1e-9);
  }
}

TEST(MakeCandidates, SharesTheWholeSquareOutAsCellAreas) {
  for (const bool merl_spacing : {true, false}) {
    for (const int count : {1, 7, 90}) {
      double total = 0;
      for (const Candidate& candidate : MakeCandidates(
               {.theta_h_count = count, .theta_d_count = 90, .merl_spacing = merl_spacing}, {})) {
        EXPECT_GT(candidate.cell_area, 0);
        total += candidate.cell_area;
      }
      EXPECT_NEAR(total, kPi * kPi / 4, 1e-10);
    }
  }
}

TEST(MakeCandidates, AsksForNinetyDegreesAcross) {
  for (const Candidate& candidate : MakeCandidates(Across(), {})) {
    EXPECT_EQ(candidate.angles.phi_d, kPi / 2);
    EXPECT_NEAR(candidate.directions.cos_theta_i(), candidate.directions.cos_theta_o(), 1e-12);
  }
}

TEST(MakeCandidates, KeepsSpreadPosesWithinMaxPolarWhereThatIsPossible) {
  const CandidateOptions options{.phi = PhiChoice::kSpread, .max_polar = RadFromDeg(75)};
  const double limit = std::cos(options.max_polar);
  int roomy = 0;
  for (const Candidate& candidate : MakeCandidates(options, {})) {
    const DirectionPair across =
        ToDirections({candidate.angles.theta_h, candidate.angles.theta_d, kPi / 2});
    // Of all phi_d, 90 degrees keeps the steeper direction least steep.
    if (across.cos_theta_i() < limit) {
      EXPECT_EQ(candidate.angles.phi_d, kPi / 2);
      continue;
    }
    ++roomy;
    EXPECT_GE(candidate.directions.cos_theta_i(), limit - 1e-12);
    EXPECT_GE(candidate.directions.cos_theta_o(), limit - 1e-12);
  }
  EXPECT_GT(roomy, 4000);
}

TEST(MakeCandidates, SpreadsPhiOverItsWholeRangeAndDiffersBetweenNeighbours) {
  const std::vector<Candidate> candidates =
      MakeCandidates({.theta_h_count = 30, .theta_d_count = 30, .phi_span = kPi}, {});
  int bins[6] = {};
  double least = kPi;
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    const double phi = candidates[i].angles.phi_d;
    ASSERT_GE(phi, 0);
    ASSERT_LT(phi, kPi);
    ++bins[static_cast<int>(phi / kPi * 6)];
    // Where there is room for any phi_d.
    if (candidates[i].row > 15 || candidates[i].column == 0 || candidates[i].column > 15) continue;
    least = std::min(least, std::abs(phi - candidates[i - 1].angles.phi_d));
  }
  for (const int bin : bins) EXPECT_GT(bin, 60);
  EXPECT_GT(least, RadFromDeg(1));
}

TEST(MakeCandidates, KeepsSpreadPhiWithinItsSpan) {
  double widest = 0;
  for (const Candidate& candidate : MakeCandidates({.phi_span = RadFromDeg(40)}, {})) {
    widest = std::max(widest, std::abs(candidate.angles.phi_d - kPi / 2));
  }
  EXPECT_LE(widest, RadFromDeg(20));
  EXPECT_GT(widest, RadFromDeg(19));
}

// Half of the raster; the lamp is tilted further from the normal than the detector.
TEST(MakeCandidates, InPlaneAreAllThatAPlaneHolds) {
  const std::vector<Candidate> candidates = MakeCandidates({.phi = PhiChoice::kInPlane}, {});
  EXPECT_GT(candidates.size(), 3000u);
  EXPECT_LT(candidates.size(), 6000u);
  for (const Candidate& candidate : candidates) {
    EXPECT_EQ(candidate.angles.phi_d, 0);
    EXPECT_LT(candidate.angles.theta_h + candidate.angles.theta_d, kPi / 2);
    EXPECT_NEAR(candidate.directions.wi.y(), 0, 1e-15);
    EXPECT_NEAR(candidate.directions.wo.y(), 0, 1e-15);
    EXPECT_LT(candidate.directions.wi.z(), candidate.directions.wo.z());
  }
}

// A detector that goes lower than the lamp takes its place, which is the same by reciprocity.
TEST(MakeCandidates, InPlaneExchangeLightAndDetectorWhereOnlyThatIsReachable) {
  const double lowest_light = std::cos(RadFromDeg(50));
  const std::vector<Candidate> all = MakeCandidates({.phi = PhiChoice::kInPlane}, {});
  const std::vector<Candidate> candidates =
      MakeCandidates({.phi = PhiChoice::kInPlane},
                     [&](const DirectionPair& pair) { return pair.wi.z() > lowest_light; });
  int exchanged = 0;
  for (const Candidate& candidate : candidates) {
    EXPECT_GT(candidate.directions.wi.z(), lowest_light);
    const HalfDiff angles = ToHalfDiff(candidate.directions);
    EXPECT_NEAR(angles.theta_h, candidate.angles.theta_h, 1e-9);
    EXPECT_NEAR(angles.theta_d, candidate.angles.theta_d, 1e-9);
    if (candidate.directions.wo.z() < lowest_light) ++exchanged;
  }
  EXPECT_GT(exchanged, 1000);
  EXPECT_GT(candidates.size(), all.size() / 2);
}

TEST(MakeCandidates, LeavesOutWhatIsNotReachable) {
  const auto shallow = [](const DirectionPair& pair) { return pair.cos_theta_i() > 0.5; };
  const std::vector<Candidate> candidates = MakeCandidates({}, shallow);
  EXPECT_GT(candidates.size(), 1000u);
  EXPECT_LT(candidates.size(), 8100u);
  for (const Candidate& candidate : candidates) EXPECT_TRUE(shallow(candidate.directions));
  EXPECT_TRUE(MakeCandidates({}, [](const DirectionPair&) { return false; }).empty());
}

}  // namespace
}  // namespace gonio
