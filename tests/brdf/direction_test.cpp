// SPDX-License-Identifier: Apache-2.0
#include "brdf/direction.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <random>
#include <vector>

#include "core/units.h"

namespace gonio {
namespace {

using Eigen::Vector3d;

// Pairs above the horizon all over the hemisphere, and the awkward ones: retro-reflection, mirror
// directions, both nearly so, and grazing.
std::vector<DirectionPair> Pairs() {
  std::vector<DirectionPair> pairs(500);
  std::mt19937 random(1);
  std::uniform_real_distribution<double> theta(0, 1.57), phi(-kPi, kPi);
  for (DirectionPair& pair : pairs) {
    pair = {FromSpherical(theta(random), phi(random)), FromSpherical(theta(random), phi(random))};
  }
  for (const double t : {0.0, 1e-9, 0.3, 1.2, 1.5707}) {
    for (const double tiny : {0.0, 1e-12, 1e-9, 1e-6}) {
      for (const double p : {-2.5, 0.0, 0.7, kPi / 2}) {
        pairs.push_back({FromSpherical(t, p), FromSpherical(t, p + tiny)});
        pairs.push_back({FromSpherical(t, p), FromSpherical(t, p + kPi + tiny)});
      }
    }
  }
  return pairs;
}

// What rounding of the vectors does to the half vector: much, where wi and wo nearly cancel.
double Rounding(const DirectionPair& pair) { return 1e-15 / (pair.wi + pair.wo).norm(); }

// Largest distance between the two pairs after the best rotation about z, with or without the
// directions swapped.
double DistanceUpToRotation(const DirectionPair& a, const DirectionPair& b) {
  double best = 10;
  for (const DirectionPair& c : {b, DirectionPair{b.wo, b.wi}}) {
    const Vector3d ha = a.wi + a.wo, hc = c.wi + c.wo;
    std::vector<double> turns;  // bring the half vectors, or one of the directions, together
    turns.push_back(std::atan2(ha.y(), ha.x()) - std::atan2(hc.y(), hc.x()));
    turns.push_back(std::atan2(a.wi.y(), a.wi.x()) - std::atan2(c.wi.y(), c.wi.x()));
    for (const double turn : turns) {
      const Eigen::AngleAxisd rotation(turn, Vector3d::UnitZ());
      const Vector3d wi = rotation * c.wi, wo = rotation * c.wo;
      best = std::min(best, std::max((wi - a.wi).norm(), (wo - a.wo).norm()));
    }
  }
  return best;
}

TEST(HalfDiff, LeadsBackToThePairUpToRotationAndReciprocity) {
  for (const DirectionPair& pair : Pairs()) {
    const DirectionPair back = ToDirections(ToHalfDiff(pair));
    EXPECT_LT(DistanceUpToRotation(pair, back), 5e-16 + 2 * Rounding(pair))
        << pair.wi.transpose() << " / " << pair.wo.transpose();
  }
}

TEST(HalfDiff, SurvivesTheRoundTripFromAnglesToVectorsAndBack) {
  for (const double theta_h : {1e-9, 1e-5, 0.3, 1.5}) {
    for (const double theta_d : {1e-9, 1e-5, 0.3, 1.5}) {
      for (const double phi_d : {0.1, 1.0, 2.0, 3.1}) {
        const HalfDiff angles{theta_h, theta_d, phi_d};
        const HalfDiff back = ToHalfDiff(ToDirections(angles));
        EXPECT_NEAR(back.theta_h, theta_h, 1e-15);
        EXPECT_NEAR(back.theta_d, theta_d, 1e-15);
        // An angle of 1e-9 is made of vectors good to 1e-16: its own direction, phi_d, to 1e-7.
        EXPECT_NEAR(back.phi_d, phi_d, theta_h < 1e-4 || theta_d < 1e-4 ? 1e-6 : 1e-13);
      }
    }
  }
}

TEST(HalfDiff, ReportsPhiZeroWhereItMeansNothing) {
  const Vector3d w = FromSpherical(0.4, 1.1);
  EXPECT_EQ(ToHalfDiff({w, w}).phi_d, 0);
  EXPECT_EQ(ToHalfDiff({w, w}).theta_d, 0);
  EXPECT_EQ(ToHalfDiff({w, {-w.x(), -w.y(), w.z()}}).phi_d, 0);
  EXPECT_EQ(ToHalfDiff({w, {-w.x(), -w.y(), w.z()}}).theta_h, 0);
}

TEST(HalfDiff, StaysInsideItsRange) {
  for (const DirectionPair& pair : Pairs()) {
    const HalfDiff angles = ToHalfDiff(pair);
    EXPECT_GE(angles.theta_h, 0);
    EXPECT_LE(angles.theta_h, kPi / 2);
    EXPECT_GE(angles.theta_d, 0);
    EXPECT_LE(angles.theta_d, kPi / 2);
    EXPECT_GE(angles.phi_d, 0);
    EXPECT_LT(angles.phi_d, kPi);
  }
}

// The distance of two phi_d on their circle of circumference pi, weighted with what it moves.
double PhiDistance(const HalfDiff& a, const HalfDiff& b) {
  const double turn = std::abs(a.phi_d - b.phi_d);
  return std::min(turn, kPi - turn) * std::sin(a.theta_h) * std::sin(a.theta_d);
}

void ExpectSame(const HalfDiff& a, const HalfDiff& b, double tolerance) {
  EXPECT_NEAR(a.theta_h, b.theta_h, tolerance);
  EXPECT_NEAR(a.theta_d, b.theta_d, 1e-15);
  EXPECT_LE(PhiDistance(a, b), 4 * tolerance);
}

TEST(HalfDiff, IsTheSameWhenLightAndDetectorAreSwapped) {
  for (const DirectionPair& pair : Pairs()) {
    ExpectSame(ToHalfDiff(pair), ToHalfDiff({pair.wo, pair.wi}), 1e-15);
  }
}

TEST(HalfDiff, IsTheSameWhenTheSampleIsTurned) {
  for (const DirectionPair& pair : Pairs()) {
    const Eigen::AngleAxisd turn(2.345, Vector3d::UnitZ());
    ExpectSame(ToHalfDiff(pair), ToHalfDiff({turn * pair.wi, turn * pair.wo}), Rounding(pair));
  }
}

TEST(HalfDiff, HasThetaDOfHalfTheAngleBetween) {
  for (const DirectionPair& pair : Pairs()) {
    EXPECT_NEAR(ToHalfDiff(pair).theta_d, AngleBetween(pair.wi, pair.wo) / 2, 1e-15);
  }
}

TEST(HalfDiff, HasThetaHOfTheHalfVector) {
  for (const DirectionPair& pair : Pairs()) {
    EXPECT_NEAR(ToHalfDiff(pair).theta_h,
                AngleBetween(pair.wi + pair.wo, Vector3d::UnitZ() * (pair.wi + pair.wo).norm()),
                1e-15);
  }
}

TEST(Cosines, AgreeWithTheVectors) {
  for (double theta_h = 0; theta_h < 1.57; theta_h += 0.1) {
    for (double theta_d = 0; theta_d < 1.57; theta_d += 0.1) {
      for (double phi_d = 0; phi_d < kPi; phi_d += 0.1) {
        const HalfDiff angles{theta_h, theta_d, phi_d};
        const DirectionPair pair = ToDirections(angles);
        double cos_i, cos_o;
        Cosines(angles, &cos_i, &cos_o);
        EXPECT_NEAR(cos_i, pair.cos_theta_i(), 1e-15);
        EXPECT_NEAR(cos_o, pair.cos_theta_o(), 1e-15);
        EXPECT_NEAR(pair.wi.norm(), 1, 1e-15);
      }
    }
  }
}

TEST(DirectionPair, IsAboveTheHorizonOnlyIfBothDirectionsAre) {
  EXPECT_TRUE((DirectionPair{FromSpherical(1.5, 0), FromSpherical(0, 0)}).above_horizon());
  EXPECT_FALSE((DirectionPair{FromSpherical(1.6, 0), FromSpherical(0, 0)}).above_horizon());
  EXPECT_FALSE((DirectionPair{FromSpherical(0, 0), FromSpherical(1.6, 0)}).above_horizon());
  EXPECT_FALSE(ToDirections({1.2, 1.2, 0}).above_horizon());
}

TEST(AngleBetween, IsAccurateWhereTheArcCosineIsNot) {
  const Vector3d z = Vector3d::UnitZ();
  EXPECT_NEAR(AngleBetween(z, FromSpherical(1e-9, 0.3)), 1e-9, 1e-24);
  EXPECT_NEAR(AngleBetween(z, -FromSpherical(1e-9, 0.3)), kPi - 1e-9, 1e-15);
  EXPECT_NEAR(AngleBetween(z, Vector3d::UnitX()), kPi / 2, 1e-15);
}

}  // namespace
}  // namespace gonio
