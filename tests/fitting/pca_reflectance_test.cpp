// SPDX-License-Identifier: Apache-2.0
#include "fitting/pca_reflectance.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <memory>
#include <vector>

#include "core/error.h"
#include "core/units.h"
#include "tests/fitting/synthetic.h"
#include "tests/fitting/training_set.h"

namespace gonio {
namespace {

const AngleGrid kGrid(30, 24, 12);

class PcaTest : public testing::Test {
 protected:
  // Mean |ln(1 + f) - ln(1 + g)| over the nodes above the horizon.
  static double Error(const Brdf& f, const Brdf& g) {
    double sum = 0;
    int count = 0;
    for (int node = 0; node < kGrid.size(); ++node) {
      if (!kGrid.Physical(node)) continue;
      const HalfDiff angles = kGrid.Inside(node);
      sum += ((1 + *f.Eval(angles)) / (1 + *g.Eval(angles))).log().abs().mean();
      ++count;
    }
    return sum / count;
  }

  const Brdf& Trained(int i) const { return *training_.materials()[i].brdf; }

  const TrainingSet training_;
};

TEST_F(PcaTest, MapsBackToWhatWasMapped) {
  const PcaBasis basis(training_.materials(), kGrid);
  for (const int node : {0, 100, 5170}) {
    for (const double f_r : {0.0, 0.01, 3.0, 500.0}) {
      EXPECT_NEAR(basis.Unmap(basis.Map(f_r, kGrid.Node(node)), node), f_r, 1e-4 * (1 + f_r));
    }
  }
  EXPECT_EQ(basis.Map(-0.1, kGrid.Node(0)), basis.Map(0, kGrid.Node(0)));
}

TEST_F(PcaTest, ComponentsAreOrthogonalAndScaledByTheirSingularValues) {
  const PcaBasis basis(training_.materials(), kGrid);
  Eigen::MatrixXd gram = Eigen::MatrixXd::Zero(basis.rank(), basis.rank());
  for (int node = 0; node < kGrid.size(); ++node) {
    if (!kGrid.Physical(node)) continue;
    const Eigen::VectorXd row = basis.Row(kGrid.Node(node));
    gram += row * row.transpose();
  }
  const double largest = std::pow(basis.singular_values()[0], 2);
  for (int i = 0; i < basis.rank(); ++i) {
    EXPECT_NEAR(gram(i, i), std::pow(basis.singular_values()[i], 2), 1e-4 * largest);
    for (int j = 0; j < i; ++j) EXPECT_NEAR(gram(i, j), 0, 1e-4 * largest);
  }
}

TEST_F(PcaTest, ReconstructsATrainingMaterialFromItsReadings) {
  const PcaBasis basis(training_.materials(), kGrid);
  const auto samples = Readings(Trained(3), 60, 0, 5);
  const auto brdf = Reconstruct(samples, basis, {.ridge = 1e-3});
  EXPECT_LT(Error(Trained(3), *brdf), 0.02);
}

TEST_F(PcaTest, ReconstructsAnUnseenMaterialBetterThanTheMean) {
  const PcaBasis basis(training_.materials(), kGrid);
  const auto material = PeakedMaterial(0.4, 40, 0.22);
  const auto mean = Reconstruct({}, basis);
  double last = Error(*material, *mean);
  for (const int poses : {4, 40}) {
    const double error = Error(*material, *Reconstruct(Readings(*material, poses, 0, 2), basis));
    EXPECT_LT(error, 0.8 * last) << poses;
    last = error;
  }
}

TEST_F(PcaTest, LeavesOutReadingsOfInfiniteSigma) {
  const PcaBasis basis(training_.materials(), kGrid);
  auto samples = Readings(Trained(1), 20, 0, 5);
  const auto without = Reconstruct(samples, basis);
  samples.push_back(samples[0]);
  samples.back().f_r = Rgb::Constant(1e6);
  samples.back().sigma = Rgb::Constant(std::numeric_limits<double>::infinity());
  EXPECT_EQ(Error(*without, *Reconstruct(samples, basis)), 0);
}

TEST_F(PcaTest, IsFiniteAboveTheHorizonAndEmptyBelow) {
  const PcaBasis basis(training_.materials(), kGrid);
  const auto brdf = Reconstruct(Readings(Trained(2), 10, 0, 5), basis);
  EXPECT_FALSE(brdf->Eval(HalfDiff{1.5, 1.5, 0}).has_value());
  for (const HalfDiff& angles : {HalfDiff{0, 0, 0}, HalfDiff{0, 1.57, 0}, HalfDiff{1.57, 0, 0},
                                 HalfDiff{1.2, 0.3, 0.2}, HalfDiff{0.9, 0.67, 0}}) {
    const auto f_r = brdf->Eval(angles);
    ASSERT_TRUE(f_r.has_value());
    EXPECT_TRUE(f_r->isFinite().all());
    EXPECT_TRUE((*f_r >= 0).all());
    EXPECT_TRUE((*f_r < 100).all());
  }
}

TEST_F(PcaTest, NamesItsMaterials) {
  const PcaBasis basis(training_.materials(), kGrid);
  ASSERT_EQ(basis.materials().size(), 8);
  EXPECT_EQ(basis.materials()[7], "7");
  EXPECT_EQ(basis.columns(), 24);
  EXPECT_LE(basis.rank(), 23);
}

TEST_F(PcaTest, RefusesLessThanTwoMaterials) {
  const std::vector<TrainingMaterial> one(1, training_.materials()[0]);
  EXPECT_THROW(PcaBasis(one, kGrid), ConfigError);
}

}  // namespace
}  // namespace gonio
