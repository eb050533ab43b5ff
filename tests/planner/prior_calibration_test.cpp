// SPDX-License-Identifier: Apache-2.0
#include "planner/prior_calibration.h"

#include <gmock/gmock.h>

#include <memory>
#include <string>

#include "fitting/process_fit.h"
#include "tests/fitting/small_process.h"

namespace gonio {
namespace {

class PriorCalibration : public testing::Test {
 protected:
  PriorCalibration() {
    for (const double roughness : {0.15, 0.22, 0.3, 0.5}) {
      for (const double albedo : {0.1, 0.3, 0.6}) {
        paints_.push_back(std::make_unique<AnalyticBrdf>(PaintOf(roughness, albedo)));
        materials_.push_back({"paint" + std::to_string(paints_.size()), paints_.back().get()});
      }
    }
  }
  std::vector<std::unique_ptr<AnalyticBrdf>> paints_;
  std::vector<TrainingMaterial> materials_;
  // Calibrated once for all tests.
  const Prior& Calibrated() {
    static const Prior prior = LearnCalibratedPrior(materials_, SmallLearnOptions(), options_);
    return prior;
  }

  CalibrationOptions options_{.folds = 3, .poses = {4, 8}, .directions = 100};
};

TEST_F(PriorCalibration, WidensAsMuchAsLeftOutMaterialsAsk) {
  const Prior plain = LearnPrior(materials_, SmallLearnOptions());
  const Prior& prior = Calibrated();
  EXPECT_EQ(prior.process->luminance, plain.process->luminance);
  ASSERT_EQ(prior.process->calibration.size(), 5u);
  for (std::size_t i = 1; i < 5; ++i) {
    // Interval ends ascend, though their widenings need not.
    const auto end = [&](std::size_t k) {
      const Calibration& at = prior.process->calibration[k];
      return at.widening * CentralQuantile(at.probability);
    };
    EXPECT_GE(end(i), end(i - 1));
  }
  EXPECT_GT(prior.process->error_margin, 0);
  EXPECT_NE(prior.process->error_margin, ProcessPrior::kUncalibratedMargin);
  // Asking for a larger share of sessions asks for a larger margin.
  options_.share = 0.2;
  EXPECT_LT(LearnCalibratedPrior(materials_, SmallLearnOptions(), options_).process->error_margin,
            prior.process->error_margin);
}

TEST_F(PriorCalibration, DoesNotDependOnTheNumberOfThreads) {
  LearnOptions two = SmallLearnOptions();
  two.threads = 2;
  const Prior& one = Calibrated();
  const Prior other = LearnCalibratedPrior(materials_, two, options_);
  EXPECT_EQ(one.process->error_margin, other.process->error_margin);
  for (std::size_t i = 0; i < 5; ++i) {
    EXPECT_EQ(one.process->calibration[i].widening, other.process->calibration[i].widening);
  }
}

TEST_F(PriorCalibration, LeavesAFewMaterialsUncalibrated) {
  materials_.resize(kLeastToCalibrate - 1);
  const Prior prior = LearnCalibratedPrior(materials_, SmallLearnOptions(), options_);
  EXPECT_TRUE(prior.process->calibration.empty());
  EXPECT_EQ(prior.process->error_margin, ProcessPrior::kUncalibratedMargin);
}

}  // namespace
}  // namespace gonio
