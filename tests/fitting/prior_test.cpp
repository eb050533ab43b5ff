// SPDX-License-Identifier: Apache-2.0
#include "fitting/prior.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>

#include "core/error.h"
#include "tests/core/temp_dir.h"

namespace gonio {
namespace {

TEST(GenericPrior, IsSymmetricAndPositiveDefiniteForEveryShape) {
  for (int lobes = 1; lobes <= kMaxLobes; ++lobes) {
    for (int knots = kMinKnots; knots <= kMaxKnots; ++knots) {
      const Prior prior = GenericPrior({lobes, knots});
      ASSERT_EQ(prior.mean.size(), prior.shape.size());
      ASSERT_EQ(prior.covariance.rows(), prior.shape.size());
      EXPECT_TRUE(prior.mean.allFinite());
      EXPECT_TRUE((prior.covariance.array() == prior.covariance.transpose().array()).all());
      const Eigen::LLT<Eigen::MatrixXd> factor(prior.covariance);
      EXPECT_EQ(factor.info(), Eigen::Success) << lobes << " lobes, " << knots << " knots";
      EXPECT_GT(factor.rcond(), 1e-9) << lobes << " lobes, " << knots << " knots";
    }
  }
}

TEST(GenericPrior, TreatsAllChannelsAlike) {
  const DsbrdfShape shape{.lobes = 3, .knots = 6};
  const Prior prior = GenericPrior(shape);
  const Eigen::Index size = shape.per_channel();
  for (int a = 0; a < kChannels; ++a) {
    EXPECT_EQ(prior.mean.segment(a * size, size), prior.mean.head(size));
    for (int b = 0; b < kChannels; ++b) {
      const auto block = prior.covariance.block(a * size, b * size, size, size);
      const auto like = prior.covariance.block(0, a == b ? 0 : size, size, size);
      EXPECT_EQ((block - like).cwiseAbs().maxCoeff(), 0);
    }
  }
}

TEST(GenericPrior, OrdersLobesFromBroadToNarrow) {
  for (int lobes = 2; lobes <= kMaxLobes; ++lobes) {
    const Prior prior = GenericPrior({lobes, 5});
    for (int k = 1; k < lobes; ++k) {
      EXPECT_GT(prior.mean[prior.shape.Index(0, k, 1)], prior.mean[prior.shape.Index(0, k - 1, 1)]);
    }
  }
}

TEST(GenericPrior, TiesChannelsAndNeighbouringKnotsTogetherButNotLobes) {
  const DsbrdfShape shape{.lobes = 2, .knots = 8};
  const Prior prior = GenericPrior(shape);
  const auto correlation = [&](int i, int j) {
    return prior.covariance(i, j) / std::sqrt(prior.covariance(i, i) * prior.covariance(j, j));
  };
  const int first = shape.Index(0, 1, 1);
  EXPECT_GT(correlation(first, first + 1), correlation(first, first + 7));
  EXPECT_GT(correlation(first, shape.Index(1, 1, 1)), 0.5);
  EXPECT_EQ(correlation(first, shape.Index(0, 0, 1)), 0);
  EXPECT_EQ(correlation(first, shape.Index(0, 1, 0)), 0);
}

TEST(GenericPrior, NamesItselfAndNoMaterial) {
  EXPECT_EQ(GenericPrior().name, "generic");
  EXPECT_TRUE(GenericPrior().materials.empty());
  EXPECT_EQ(GenericPrior().shape, DsbrdfShape{});
}

TEST(GenericPrior, RefusesABadShape) {
  EXPECT_EQ(MessageOf<ConfigError>([] { GenericPrior({0, 7}); }), "lobes: is 0, must be 1 to 5");
}

}  // namespace
}  // namespace gonio
