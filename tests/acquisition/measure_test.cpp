// SPDX-License-Identifier: Apache-2.0
#include "acquisition/measure.h"

#include <gmock/gmock.h>

#include "acquisition/radiometry.h"
#include "tests/acquisition/simulated_rig.h"

namespace gonio {
namespace {

using testing::HasSubstr;
using testing::StartsWith;

const FlatBrdf kPaper(Rgb(0.3, 0.3, 0.3));

// A lobe that saturates everything near the mirror direction.
class Mirror final : public Brdf {
 public:
  std::optional<Rgb> Eval(const HalfDiff& angles) const override {
    return Rgb::Constant(angles.theta_h < RadFromDeg(1) ? peak : 0.01);
  }
  std::string name() const override { return "mirror"; }
  double peak = 3000;
};

TEST(PoseMeasurer, MeasuresAPaperInOneFrameWhenItKnowsWhatToExpect) {
  SimulatedRig rig(kPaper);
  PoseMeasurer measurer = rig.Prepared();
  const auto record = measurer.Measure(PairAt(20, 30), Rgb(0.3, 0.3, 0.3), {});
  ASSERT_TRUE(record.ok());
  EXPECT_EQ(record->exposures.size(), 1);
  EXPECT_EQ(measurer.position(), record->readback);
  const BrdfSample sample = Reduce(*record, rig.rig).front();
  for (int c = 0; c < kChannels; ++c) {
    EXPECT_NEAR(sample.f_r[c], 0.3, 5 * sample.sigma[c]);
    EXPECT_NEAR(sample.sigma[c] / 0.3, 0.0122, 0.0005);
  }
}

class OverRange final : public Monitor {
 public:
  const std::string& name() const override { return name_; }
  const std::string& identity() const override { return name_; }
  Result<double> Read() override { return Error{ErrorCode::kRefused, "monitor: no reading"}; }

 private:
  const std::string name_ = "monitor";
};

// Example failure is a night of poses that are skipped one after the other.
TEST(PoseMeasurer, DoesNotSkipAPoseForWantOfAMonitor) {
  SimulatedRig rig(kPaper);
  PoseMeasurer measurer = rig.Prepared();
  rig.devices.monitor = std::make_unique<OverRange>();
  const auto record = measurer.Measure(PairAt(20, 30), Rgb(0.3, 0.3, 0.3), {});
  ASSERT_FALSE(record.ok());
  EXPECT_EQ(record.error().code, ErrorCode::kProtocol);
  EXPECT_EQ(record.error().message, "monitor: no reading");
}

TEST(PoseMeasurer, RepeatsTheFrameThatSuitsAsOftenAsAskedAndAllowed) {
  SimulatedRig rig(kPaper);
  PoseMeasurer measurer = rig.Prepared();
  const auto four = measurer.Measure(PairAt(20, 30), Rgb(0.3, 0.3, 0.3), {}, 4);
  ASSERT_TRUE(four.ok());
  ASSERT_EQ(four->exposures.size(), 4);
  for (const Exposure& e : four->exposures) {
    EXPECT_EQ(e.frame.exposure, four->exposures.front().frame.exposure);
  }
  const BrdfSample sample = Reduce(*four, rig.rig).front();
  for (int c = 0; c < kChannels; ++c) EXPECT_NEAR(sample.sigma[c] / 0.3, 0.0061, 0.0003);
  const auto many = measurer.Measure(PairAt(20, 30), Rgb(0.3, 0.3, 0.3), {}, 99);
  ASSERT_TRUE(many.ok());
  EXPECT_EQ(std::ssize(many->exposures), rig.rig.exposure.max_frames);
}

TEST(PoseMeasurer, ExposesOnlyWhatIsStillAndSettled) {
  SimulatedRig rig(kPaper);
  PoseMeasurer measurer = rig.Prepared();
  for (int i = 0; i < 20; ++i) {
    const auto record = measurer.Measure(PairAt(2 + 3 * i, 20, 40 + 5 * i), std::nullopt, {});
    ASSERT_TRUE(record.ok());
    const Seconds still = record->start + record->move_time;
    EXPECT_GT(record->move_time.count(), 0);
    for (const Exposure& e : record->exposures) {
      EXPECT_GE(e.frame.start.count(), (still + rig.rig.motion.settle).count() - 1e-9);
    }
    EXPECT_GE(record->end, record->exposures.back().frame.start);
    for (const auto& motor : rig.motors) {
      EXPECT_FALSE(motor->MovingBetween(record->exposures.front().frame.start, record->end));
    }
  }
}

TEST(PoseMeasurer, RemembersTheLastPosesExposure) {
  const FlatBrdf bright(Rgb::Constant(30));
  SimulatedRig rig(bright);
  PoseMeasurer measurer = rig.Prepared();
  ASSERT_TRUE(measurer.Measure(PairAt(10, 30), std::nullopt, {}).ok());
  const auto second = measurer.Measure(PairAt(12, 30), std::nullopt, {});
  ASSERT_TRUE(second.ok());
  EXPECT_EQ(second->exposures.size(), 1);
}

TEST(PoseMeasurer, RefusesAPoseOutOfReachWithoutMoving) {
  SimulatedRig rig(kPaper);
  PoseMeasurer measurer = rig.Prepared();
  const Seconds before = rig.clock.Now();
  const auto record = measurer.Measure(PairAt(20, 1), std::nullopt, {});
  ASSERT_FALSE(record.ok());
  EXPECT_EQ(record.error().code, ErrorCode::kRefused);
  EXPECT_EQ(record.error().message,
            "pose theta_h 20.00, theta_d 1.00, phi_d 90.00 deg: out of reach");
  EXPECT_EQ(rig.clock.Now(), before);
}

TEST(PoseMeasurer, FindsAMirrorPeakItDidNotExpect) {
  const Mirror mirror;
  SimulatedRig rig(mirror);
  PoseMeasurer measurer = rig.Prepared();
  const auto record = measurer.Measure(PairAt(0, 30), Rgb(0.01, 0.01, 0.01), {});
  ASSERT_TRUE(record.ok());
  const BrdfSample sample = Reduce(*record, rig.rig).front();
  for (int c = 0; c < kChannels; ++c) EXPECT_NEAR(sample.f_r[c], 3000, 5 * sample.sigma[c]);
}

TEST(PoseMeasurer, RefusesWhatSaturatesTheShortestExposure) {
  Mirror mirror;
  mirror.peak = 1e7;
  SimulatedRig rig(mirror);
  PoseMeasurer measurer = rig.Prepared();
  const auto record = measurer.Measure(PairAt(0, 30), std::nullopt, {});
  ASSERT_FALSE(record.ok());
  EXPECT_EQ(record.error().code, ErrorCode::kRefused);
  EXPECT_EQ(record.error().message, "saturated at the shortest exposure");
  // The next pose is not spoilt by it.
  EXPECT_TRUE(measurer.Measure(PairAt(20, 30), std::nullopt, {}).ok());
}

TEST(PoseMeasurer, SaysWhenItRanOutOfFrames) {
  Mirror mirror;
  mirror.peak = 1e7;
  RigConfig config = DefaultRig();
  config.exposure.max_frames = 2;
  SimulatedRig rig(mirror, 1, config);
  PoseMeasurer measurer = rig.Prepared();
  const auto record = measurer.Measure(PairAt(0, 30), std::nullopt, {});
  ASSERT_FALSE(record.ok());
  EXPECT_EQ(record.error().message, "saturated in all 2 frames");
}

TEST(PoseMeasurer, GivesOneSaturatedChannelAnInfiniteSigma) {
  const FlatBrdf red(Rgb(1e7, 0.3, 0.3));
  SimulatedRig rig(red);
  PoseMeasurer measurer = rig.Prepared();
  const auto record = measurer.Measure(PairAt(20, 30), std::nullopt, {});
  ASSERT_TRUE(record.ok());
  EXPECT_LE(std::ssize(record->exposures), rig.rig.exposure.max_frames);
  const BrdfSample sample = Reduce(*record, rig.rig).front();
  EXPECT_TRUE(std::isinf(sample.sigma[0]));
  EXPECT_EQ(sample.f_r[0], 0);
  EXPECT_NEAR(sample.f_r[1], 0.3, 5 * sample.sigma[1]);
}

TEST(PoseMeasurer, MeasuresDarkClothInTwoSeconds) {
  const FlatBrdf cloth(Rgb::Constant(0.002));
  SimulatedRig rig(cloth);
  PoseMeasurer measurer = rig.Prepared();
  const auto record = measurer.Measure(PairAt(10, 30), Rgb(0.002, 0.002, 0.002), {});
  ASSERT_TRUE(record.ok());
  double exposed = 0;
  for (const Exposure& e : record->exposures) exposed += e.frame.exposure.count();
  EXPECT_LT(exposed, 2);
  const BrdfSample sample = Reduce(*record, rig.rig).front();
  for (int c = 0; c < kChannels; ++c) {
    EXPECT_NEAR(sample.f_r[c], 0.002, 5 * sample.sigma[c]);
    EXPECT_LT(sample.sigma[c], 0.03 * 0.002);
  }
}

TEST(PoseMeasurer, CallsADarkLampAFault) {
  SimulatedRig rig(kPaper);
  PoseMeasurer measurer = rig.Prepared();
  rig.lamp->set_level(0);
  const auto record = measurer.Measure(PairAt(20, 30), std::nullopt, {});
  ASSERT_FALSE(record.ok());
  EXPECT_EQ(record.error().code, ErrorCode::kProtocol);
  EXPECT_THAT(record.error().message, StartsWith("monitor: reads 0 with the light at 1"));
}

TEST(PoseMeasurer, RefusesToStartUnhomed) {
  SimulatedRig rig(kPaper);
  PoseMeasurer measurer(rig.rig, rig.devices, rig.clock);
  const auto record = measurer.Measure(PairAt(20, 30), std::nullopt, {});
  ASSERT_FALSE(record.ok());
  EXPECT_EQ(record.error().code, ErrorCode::kProtocol);
  EXPECT_THAT(record.error().message, HasSubstr("has lost its reference"));
}

TEST(PoseMeasurer, IsCancelledWithTheAxesAtRest) {
  SimulatedRig rig(kPaper);
  PoseMeasurer measurer = rig.Prepared();
  std::stop_source stop;
  stop.request_stop();
  const auto record = measurer.Measure(PairAt(20, 30), std::nullopt, stop.get_token());
  ASSERT_FALSE(record.ok());
  EXPECT_EQ(record.error().code, ErrorCode::kCancelled);
  for (const auto& motor : rig.motors) EXPECT_FALSE(motor->Moving());
}

TEST(PoseMeasurer, RepeatsMovesOfASloppyAxis) {
  RigConfig config = DefaultRig();
  SimConfig truth = DefaultTruth();
  truth.repeatability = config.axes[0].position_tolerance;  // one move in three misses
  config.motion.retries = 10;
  SimulatedRig rig(kPaper, 3, config, truth);
  PoseMeasurer measurer = rig.Prepared();
  int retries = 0;
  for (int i = 0; i < 20; ++i) {
    const auto record = measurer.Measure(PairAt(5 + 2 * i, 30), std::nullopt, {});
    ASSERT_TRUE(record.ok()) << record.error().message;
    retries += record->move_retries;
    for (int a = 0; a < kAxes; ++a) {
      EXPECT_LE(std::abs(record->readback[a] - record->commanded[a]),
                config.axes[a].position_tolerance);
    }
  }
  EXPECT_GT(retries, 5);
}

TEST(PoseMeasurer, SameSeedSameRecord) {
  const auto run = [](std::uint64_t seed) {
    SimulatedRig rig(kPaper, seed);
    PoseMeasurer measurer = rig.Prepared();
    return measurer.Measure(PairAt(20, 30), std::nullopt, {}).value();
  };
  const PoseRecord a = run(7);
  const PoseRecord b = run(7);
  EXPECT_EQ(a.readback, b.readback);
  EXPECT_EQ(a.exposures.back().frame.counts, b.exposures.back().frame.counts);
  EXPECT_EQ(a.exposures.back().monitor, b.exposures.back().monitor);
  EXPECT_NE(a.exposures.back().frame.counts, run(8).exposures.back().frame.counts);
}

}  // namespace
}  // namespace gonio
