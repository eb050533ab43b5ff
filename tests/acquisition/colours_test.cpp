// SPDX-License-Identifier: Apache-2.0
// A mono camera in front of a light with colours.

#include <gmock/gmock.h>

#include <cmath>

#include "acquisition/measure.h"
#include "acquisition/radiometry.h"
#include "acquisition/session_costs.h"
#include "acquisition/time_estimate.h"
#include "tests/acquisition/simulated_rig.h"

namespace gonio {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

const Rgb kCloth(0.1, 0.3, 0.05);
const FlatBrdf kColoured(kCloth);

// As bright as it likes near the mirror direction, black elsewhere.
class Mirror final : public Brdf {
 public:
  explicit Mirror(const Rgb& peak) : peak_(peak) {}
  std::optional<Rgb> Eval(const HalfDiff& angles) const override {
    return angles.theta_h < RadFromDeg(1) ? peak_ : Rgb(Rgb::Constant(0.01));
  }
  std::string name() const override { return "mirror"; }

 private:
  Rgb peak_;
};

std::vector<LightColour> ColoursOf(const PoseRecord& record) {
  std::vector<LightColour> colours;
  for (const Exposure& e : record.exposures) {
    if (colours.empty() || colours.back() != *e.colour) colours.push_back(*e.colour);
  }
  return colours;
}

int FramesIn(const PoseRecord& record, LightColour colour) {
  return static_cast<int>(std::count_if(record.exposures.begin(), record.exposures.end(),
                                        [&](const Exposure& e) { return e.colour == colour; }));
}

void ExpectMeasures(const PoseRecord& record, const RigConfig& rig, const Rgb& f_r) {
  const BrdfSample sample = Reduce(record, rig).front();
  for (int c = 0; c < kChannels; ++c) {
    EXPECT_NEAR(sample.f_r[c], f_r[c], 5 * sample.sigma[c]) << kChannelNames[c];
    EXPECT_LT(sample.sigma[c], 0.03 * f_r[c]) << kChannelNames[c];
  }
}

TEST(ColouredLight, AForetoldPoseTakesOneFrameInEachColour) {
  SimulatedRig rig(kColoured, 1, LedRig());
  PoseMeasurer measurer = rig.Prepared();
  const auto record = measurer.Measure(PairAt(20, 30), kCloth, {});
  ASSERT_TRUE(record.ok()) << record.error().message;
  ASSERT_EQ(record->exposures.size(), 3);
  ExpectMeasures(*record, rig.rig, kCloth);
  // Each at its own target, which one exposure for all cannot be.
  for (const Exposure& e : record->exposures) {
    const FrameMeans means = MeansOf(e.frame, rig.rig.camera.full_scale, record->regions, e.colour);
    const double level = means.counts[ChannelOf(*e.colour)] / rig.rig.camera.full_scale;
    if (e.frame.exposure < rig.rig.exposure.soft_limit) {
      EXPECT_NEAR(level, rig.rig.exposure.target_fraction, 0.05);
    }
    EXPECT_EQ(means.pixels.sum(), rig.rig.camera.width * rig.rig.camera.height);
  }
}

// Two changes a pose: no wheel turns back before the first frame.
TEST(ColouredLight, GoesToAndFroThroughTheColours) {
  SimulatedRig rig(kColoured, 1, LedRig());
  PoseMeasurer measurer = rig.Prepared();
  using enum LightColour;
  for (int i = 0; i < 4; ++i) {
    const auto record = measurer.Measure(PairAt(20 + i, 30), kCloth, {});
    ASSERT_TRUE(record.ok());
    if (i % 2 == 0) {
      EXPECT_THAT(ColoursOf(*record), ElementsAre(kRed, kGreen, kBlue));
    } else {
      EXPECT_THAT(ColoursOf(*record), ElementsAre(kBlue, kGreen, kRed));
    }
  }
}

TEST(ColouredLight, RepeatsWhatSuitsInEachColour) {
  SimulatedRig rig(kColoured, 1, LedRig());
  PoseMeasurer measurer = rig.Prepared();
  const auto four = measurer.Measure(PairAt(20, 30), kCloth, {}, 4);
  ASSERT_TRUE(four.ok());
  for (const LightColour colour : kLightColours) EXPECT_EQ(FramesIn(*four, colour), 4);
  EXPECT_EQ(ColoursOf(*four).size(), 3);
  const auto many = measurer.Measure(PairAt(20, 30), kCloth, {}, 99);
  ASSERT_TRUE(many.ok());
  for (const LightColour colour : kLightColours) {
    EXPECT_EQ(FramesIn(*many, colour), rig.rig.exposure.max_frames);
  }
}

// Example failure is a highlight that every colour has to find by itself.
TEST(ColouredLight, OnlyTheFirstColourIsSurprisedByAHighlight) {
  const Rgb peak(3000, 2500, 2800);
  const Mirror mirror(peak);
  SimulatedRig watched(mirror, 1, LedRig());
  PoseMeasurer measurer = watched.Prepared();
  const auto record = measurer.Measure(PairAt(0, 30), Rgb(0.01, 0.01, 0.01), {});
  ASSERT_TRUE(record.ok()) << record.error().message;
  EXPECT_GT(FramesIn(*record, LightColour::kRed), 2);
  EXPECT_EQ(FramesIn(*record, LightColour::kGreen), 1);
  EXPECT_EQ(FramesIn(*record, LightColour::kBlue), 1);
  ExpectMeasures(*record, watched.rig, peak);
}

TEST(ColouredLight, RemembersEachColourOfTheLastPose) {
  const FlatBrdf bright(Rgb(30, 3, 0.3));
  SimulatedRig rig(bright, 1, LedRig());
  PoseMeasurer measurer = rig.Prepared();
  ASSERT_TRUE(measurer.Measure(PairAt(10, 30), std::nullopt, {}).ok());
  const auto second = measurer.Measure(PairAt(12, 30), std::nullopt, {});
  ASSERT_TRUE(second.ok());
  EXPECT_EQ(second->exposures.size(), 3);
  ExpectMeasures(*second, rig.rig, Rgb(30, 3, 0.3));
}

TEST(ColouredLight, AChannelThatAlwaysSaturatesIsNotMeasuredAndTheOthersAre) {
  const FlatBrdf red(Rgb(1e7, 0.3, 0.3));
  SimulatedRig rig(red, 1, LedRig());
  PoseMeasurer measurer = rig.Prepared();
  const auto record = measurer.Measure(PairAt(20, 30), std::nullopt, {});
  ASSERT_TRUE(record.ok()) << record.error().message;
  const BrdfSample sample = Reduce(*record, rig.rig).front();
  EXPECT_TRUE(std::isinf(sample.sigma[0]));
  EXPECT_NEAR(sample.f_r[1], 0.3, 5 * sample.sigma[1]);
  EXPECT_NEAR(sample.f_r[2], 0.3, 5 * sample.sigma[2]);

  const FlatBrdf dazzling(Rgb::Constant(1e7));
  SimulatedRig hopeless(dazzling, 1, LedRig());
  PoseMeasurer refused = hopeless.Prepared();
  const auto none = refused.Measure(PairAt(20, 30), std::nullopt, {});
  ASSERT_FALSE(none.ok());
  EXPECT_EQ(none.error().code, ErrorCode::kRefused);
  EXPECT_EQ(none.error().message, "saturated at the shortest exposure");
}

TEST(ColouredLight, AWheelStandsStillWhileAFrameIsExposed) {
  SimulatedRig rig(kColoured, 1, WheelRig());
  PoseMeasurer measurer = rig.Prepared();
  for (int i = 0; i < 4; ++i) {
    const auto record = measurer.Measure(PairAt(20 + i, 30), kCloth, {});
    ASSERT_TRUE(record.ok()) << record.error().message;
    EXPECT_EQ(record->exposures.size(), 3);
    ExpectMeasures(*record, rig.rig, kCloth);
    for (const Exposure& e : record->exposures) {
      EXPECT_FALSE(rig.wheel->MovingBetween(e.frame.start, e.frame.start + e.frame.exposure));
    }
    const double changes = ColourChangesOf(rig.rig).count();
    EXPECT_NEAR(changes, (1.5 / 2 + 2.0 / 8) + (2.0 / 2 + 2.0 / 8) + 2 * 0.02, 1e-9);
    double exposed = 0;
    for (const Exposure& e : record->exposures) {
      exposed += (e.frame.exposure + rig.rig.camera.readout).count();
    }
    const Seconds still = record->start + record->move_time + rig.rig.motion.settle;
    if (i > 0) {
      EXPECT_NEAR((record->end - still).count(), changes + exposed, 1e-2);
    }
  }
}

// Example failure is a night of poses that are skipped, one after the other.
TEST(ColouredLight, AWheelThatMissesEndsTheSession) {
  SimConfig truth = DefaultTruth();
  truth.repeatability = RadFromDeg(5);
  SimulatedRig rig(kColoured, 1, WheelRig(), truth);
  PoseMeasurer measurer(rig.rig, rig.devices, rig.clock);
  const auto prepared = measurer.Prepare({});
  ASSERT_FALSE(prepared.ok());
  EXPECT_EQ(prepared.error().code, ErrorCode::kProtocol);
  EXPECT_THAT(prepared.error().message, HasSubstr("filter_wheel: stands at"));
}

// Example failure is the red LED that somebody switched on at the knob between two poses.
TEST(ColouredLight, ReadsBackTheColourBeforeItIsBelieved) {
  SimulatedRig rig(kColoured, 1, LedRig());
  PoseMeasurer measurer = rig.Prepared();
  ASSERT_TRUE(measurer.Measure(PairAt(20, 30), kCloth, {}).ok());
  rig.lamp->Select(LightColour::kGreen);
  const auto record = measurer.Measure(PairAt(22, 30), kCloth, {});
  ASSERT_TRUE(record.ok());
  ExpectMeasures(*record, rig.rig, kCloth);
}

// A twentieth of each LED's light lies in a neighbour's band.
TEST(ColouredLight, CrosstalkMixesNeighbours) {
  SimConfig truth = DefaultTruth();
  truth.colour_crosstalk = 0.05;
  SimulatedRig rig(kColoured, 1, LedRig(), truth);
  PoseMeasurer measurer = rig.Prepared();
  const auto record = measurer.Measure(PairAt(20, 30), kCloth, {}, 8);
  ASSERT_TRUE(record.ok());
  const Rgb r = LedRig().radiometry.responsivity;
  const Rgb seen = r * kCloth;
  ExpectMeasures(*record, rig.rig,
                 Rgb(0.95 * seen[0] + 0.05 * seen[1], 0.90 * seen[1] + 0.05 * (seen[0] + seen[2]),
                     0.95 * seen[2] + 0.05 * seen[1]) /
                     r);
}

// Time estimates are of three frames, each of its own exposure, and two changes.
TEST(ColouredLight, CostsAFrameInEachColourAndTheChanges) {
  const RigConfig rig = WheelRig();
  const SessionCosts costs = CostsOn(rig);
  const double changes = ColourChangesOf(rig).count();
  const DirectionPair pair = PairAt(20, 30);
  double exposures = 0;
  for (int c = 0; c < kChannels; ++c) {
    Rgb own = Rgb::Zero();
    own[c] = CountRates(kCloth, pair.cos_theta_i(), 1, rig.radiometry)[c];
    exposures += (FirstExposure(own, rig) + rig.camera.readout).count();
  }
  EXPECT_NEAR(costs.frame(pair, kCloth), exposures, 1e-9);
  EXPECT_NEAR(costs.pose(pair, kCloth), rig.motion.settle.count() + changes + exposures, 1e-9);
  EXPECT_NEAR(NominalExposing(rig).count(), 3 * 3 * 0.33 + changes, 1e-9);
  // Each colour is exposed until it is bright: darker ones are less uncertain than in one frame.
  const Rgb noise = NoiseOn(rig)(pair, kCloth);
  RigConfig white = rig;
  white.by_colour = false;
  EXPECT_LT(noise[2], NoiseOn(white)(pair, kCloth)[2]);
}

}  // namespace
}  // namespace gonio
