// SPDX-License-Identifier: Apache-2.0
#include "fitting/dsbrdf.h"

#include <gtest/gtest.h>

#include <cmath>

#include "core/error.h"
#include "fitting/slice.h"
#include "tests/core/temp_dir.h"
#include "tests/fitting/synthetic.h"

namespace gonio {
namespace {

TEST(DsbrdfShape, GivesEveryCoefficientItsOwnIndex) {
  for (int lobes = 1; lobes <= kMaxLobes; ++lobes) {
    for (const int knots : {kMinKnots, 7, kMaxKnots}) {
      const DsbrdfShape shape{lobes, knots};
      std::vector<int> taken(shape.size(), 0);
      for (int c = 0; c < kChannels; ++c) {
        for (int k = 0; k < lobes; ++k) {
          for (int q = 0; q < 2; ++q) {
            for (int j = 0; j < knots; ++j) ++taken.at(shape.Index(c, k, q) + j);
          }
        }
      }
      EXPECT_EQ(taken, std::vector<int>(shape.size(), 1));
    }
  }
}

TEST(DsbrdfShape, IsRefusedOutsideItsRange) {
  const auto complaint = [](int lobes, int knots) {
    return MessageOf<ConfigError>([&] { CheckShape({lobes, knots}); });
  };
  EXPECT_EQ(complaint(0, 7), "lobes: is 0, must be 1 to 5");
  EXPECT_EQ(complaint(7, 7), "lobes: is 7, must be 1 to 5");
  EXPECT_EQ(complaint(3, 3), "knots: is 3, must be 4 to 20");
  EXPECT_EQ(complaint(3, 21), "knots: is 21, must be 4 to 20");
  EXPECT_NO_THROW(CheckShape({1, 4}));
  EXPECT_NO_THROW(CheckShape({5, 20}));
  EXPECT_NO_THROW(CheckShape({}));
}

TEST(Dsbrdf, RefusesABadShape) {
  EXPECT_EQ(MessageOf<ConfigError>([] {
              Dsbrdf({6, 7}, Eigen::VectorXd::Zero(252));
            }),
            "lobes: is 6, must be 1 to 5");
}

TEST(DsbrdfDeathTest, AbortsOnParametersOfAnotherShape) {
  EXPECT_DEATH(Dsbrdf({3, 7}, Eigen::VectorXd::Zero(125)), "one coefficient per spline knot");
}

TEST(Dsbrdf, IsItsSliceAtEveryThetaD) {
  for (int lobes = 1; lobes <= kMaxLobes; ++lobes) {
    const Dsbrdf brdf = SyntheticMaterial(3, {lobes, 8});
    for (const double theta_d : {0.0, 0.4, 1.1}) {
      const Slice slice(brdf.shape(), brdf.parameters(), theta_d);
      for (const double theta_h : {0.0, 0.01, 0.3, 1.0}) {
        const Rgb f_r = *brdf.Eval(HalfDiff{theta_h, theta_d, kPi / 2});
        for (int c = 0; c < kChannels; ++c) EXPECT_EQ(f_r[c], slice.Eval(c, LogCos(theta_h)));
      }
    }
  }
}

TEST(Dsbrdf, KnowsNothingBelowTheHorizon) {
  const Dsbrdf brdf = SyntheticMaterial(1);
  EXPECT_FALSE(brdf.Eval(HalfDiff{RadFromDeg(60), RadFromDeg(60), 0}).has_value());
  EXPECT_TRUE(brdf.Eval(HalfDiff{RadFromDeg(60), RadFromDeg(60), kPi / 2}).has_value());
}

TEST(Dsbrdf, IsFiniteAndNonNegativeAtEveryPose) {
  const Dsbrdf brdf = SyntheticMaterial(2);
  Random random(1, 0);
  for (int n = 0; n < 2000; ++n) {
    const Rgb f_r = *brdf.Eval(RandomPose(random));
    EXPECT_TRUE(f_r.isFinite().all());
    EXPECT_GE(f_r.minCoeff(), 0);
  }
  const double grazing = RadFromDeg(89.999);
  EXPECT_TRUE(brdf.Eval(HalfDiff{grazing, 0, 0})->isFinite().all());
  EXPECT_TRUE(brdf.Eval(HalfDiff{0, grazing, 0})->isFinite().all());
}

TEST(Dsbrdf, DoesNotDependOnPhiD) {
  const Dsbrdf brdf = SyntheticMaterial(4);
  const Rgb reference = *brdf.Eval(HalfDiff{0.3, 0.5, kPi / 2});
  for (int i = 0; i < 18; ++i) {
    const Rgb f_r = *brdf.Eval(HalfDiff{0.3, 0.5, i * kPi / 18});
    EXPECT_TRUE((f_r == reference).all());
  }
}

TEST(Dsbrdf, IsReciprocalAndIsotropic) {
  const Dsbrdf brdf = SyntheticMaterial(5);
  Random random(2, 0);
  for (int n = 0; n < 500; ++n) {
    const DirectionPair pair = RandomPose(random);
    const Rgb f_r = *brdf.Eval(pair);
    const Rgb swapped = *brdf.Eval(DirectionPair{pair.wo, pair.wi});
    const auto turned = [](const Eigen::Vector3d& w) {
      return Eigen::Vector3d(0.6 * w.x() - 0.8 * w.y(), 0.8 * w.x() + 0.6 * w.y(), w.z());
    };
    const Rgb rotated = *brdf.Eval(DirectionPair{turned(pair.wi), turned(pair.wo)});
    EXPECT_LT((f_r - swapped).abs().maxCoeff(), 1e-9 * (1 + f_r.maxCoeff()));
    EXPECT_LT((f_r - rotated).abs().maxCoeff(), 1e-9 * (1 + f_r.maxCoeff()));
  }
}

}  // namespace
}  // namespace gonio
