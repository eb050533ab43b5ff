// SPDX-License-Identifier: Apache-2.0
// Whole sessions on every kind of rig, against the truth.
#include <gmock/gmock.h>

#include "acquisition/event_log.h"
#include "acquisition/radiometry.h"
#include "acquisition/session.h"
#include "acquisition/session_check.h"
#include "acquisition/session_record.h"
#include "brdf/analytic.h"
#include "brdf/metrics.h"
#include "fitting/fit.h"
#include "planner/plan.h"
#include "tests/acquisition/rig_kinds.h"
#include "tests/core/temp_dir.h"

namespace gonio {
namespace {

constexpr int kPoses = 40;

class SessionOn : public testing::TestWithParam<KindOfRig> {
 protected:
  SessionOn() : plan_(LoadPlan(std::string(GONIO_SOURCE_DIR) + "/configs/plan-information.yaml")) {
    const std::string text = TextOf(GetParam());
    SimConfig truth = ReadSim(ConfigNode::Parse(text, GetParam().file));
    bench_ = std::make_unique<SimulatedRig>(paint_, 1, RigOf(GetParam()), truth);
    plan_.max_poses = kPoses;
    if (IsInPlane(GetParam().kind)) plan_.StayInPlane();
  }

  SessionInfo Info() const {
    SessionInfo info;
    info.rig_text = bench_->rig.text;
    const auto axes = bench_->rig.axis_names();
    info.axes.assign(axes.begin(), axes.end());
    return info;
  }

  SessionSummary Run(EventLog& log) {
    const PathPlanner paths(bench_->rig);
    const auto planner = MakePlanner(
        plan_, {.reachable = [&](const DirectionPair& pair) {
          return paths.PlanTo(paths.kinematics().Inverse(pair, {}).value_or(AxisPositions{}), pair)
              .ok();
        }});
    return RunSession({bench_->rig, bench_->devices, bench_->clock, *planner, &log}, {}, {}, {});
  }

  // Fresnel's law and a lobe: what is seen under wrong directions is not what is there.
  const AnalyticBrdf paint_{"paint",
                            {Lambert{Rgb(0.3, 0.2, 0.1)}, Ggx{.roughness = 0.25, .ior = 1.5}}};
  Plan plan_;
  std::unique_ptr<SimulatedRig> bench_;
  const TempDir dir_;
};
INSTANTIATE_TEST_SUITE_P(All, SessionOn, testing::ValuesIn(kEveryKind), NameOf);

TEST_P(SessionOn, MeasuresWhatIsThere) {
  SessionSummary summary;
  {
    EventLog log = EventLog::Create(dir_ / "s", Info());
    summary = Run(log);
  }
  ASSERT_EQ(summary.outcome, SessionOutcome::kComplete) << summary.reason;
  ASSERT_EQ(summary.poses.size(), static_cast<std::size_t>(kPoses));
  EXPECT_EQ(summary.rejected, 0);
  for (const BrdfSample& sample : summary.Samples()) {
    const Rgb truth = *paint_.Eval(sample.directions);
    EXPECT_TRUE(((sample.f_r - truth).abs() < 5 * sample.sigma).all()) << sample.f_r.transpose();
  }
  const auto fit = FitDsbrdf(summary.Samples(), plan_.prior, plan_.fit);
  EXPECT_LT(Compare(paint_, fit, {.phi_stride = 12, .theta_d_stride = 4}).male, 0.02);

  // The session on disk has the rig's axes by their names, and reads back what encoders said.
  const SessionRecord record = ReadSession(dir_ / "s");
  EXPECT_EQ(record.info.axes, Info().axes);
  const Kinematics kinematics(bench_->rig);
  for (std::size_t i = 0; i < record.poses.size(); ++i) {
    const MeasuredPose& pose = record.poses[i];
    const DirectionPair there = kinematics.Forward(pose.readback);
    EXPECT_LT((there.wi - summary.poses[i].samples.front().directions.wi).norm(), 1e-9);
    EXPECT_LT((there.wo - summary.poses[i].samples.front().directions.wo).norm(), 1e-9);
  }
}

// Of a sphere, whose image holds a fan of directions. Example failure is an image that rolls with
// the sample and whose pixels do not.
TEST_P(SessionOn, GivesEachPartOfAnImageTheReflectanceOfItsDirections) {
  RigConfig rig = RigOf(GetParam());
  rig.camera.width = rig.camera.height = 96;
  rig.imaging = {.focal_length = 1500,
                 .camera_distance = 0.5,
                 .light_distance = 0.8,
                 .patch_radius = 0.012,
                 .shape = {.kind = SampleShape::Kind::kSphere, .radius = 0.02}};
  rig.samples_per_image = 256;
  SimConfig truth;  // no imperfection
  truth.rig = GetParam().truth;
  truth.axes = rig.axis_count;
  truth.responsivity = rig.radiometry.responsivity;
  truth.electrons_per_count = rig.radiometry.electrons_per_count;
  rig.radiometry = {.responsivity = truth.responsivity,
                    .electrons_per_count = truth.electrons_per_count};
  // Dull enough to be the same over a part.
  const AnalyticBrdf dull("dull", {Lambert{{0.3, 0.2, 0.1}}, Ggx{.roughness = 0.5, .ior = 1.5}});
  SimulatedRig simulated(dull, 1, rig, truth);
  PoseMeasurer measurer = simulated.Prepared();
  const double across = IsInPlane(GetParam().kind) ? 180 : 60;
  for (const double phi_d : {0.0, across}) {
    const auto record = measurer.Measure(PairAt(15, 30, phi_d), std::nullopt, {});
    ASSERT_TRUE(record.ok()) << record.error().message;
    int readings = 0;
    for (const BrdfSample& sample : Reduce(*record, rig)) {
      const Rgb error = (sample.f_r - *dull.Eval(sample.directions)).abs();
      EXPECT_TRUE((error < 0.02 * sample.f_r + 4 * sample.sigma).all()) << error.transpose();
      ++readings;
    }
    EXPECT_EQ(readings, 256);
  }
}

TEST_P(SessionOn, IsRescuedWithItsAxes) {
  plan_.max_poses = 5;
  {
    EventLog log = EventLog::Create(dir_ / "s", Info());
    (void)Run(log);
  }
  EXPECT_EQ(RescueSession(dir_ / "s", dir_ / "r").poses, 5);
  const SessionRecord before = ReadSession(dir_ / "s");
  const SessionRecord after = ReadSession(dir_ / "r");
  EXPECT_EQ(after.info.axes, before.info.axes);
  ASSERT_EQ(after.poses.size(), 5u);
  EXPECT_EQ(after.poses[4].readback, before.poses[4].readback);
}

}  // namespace
}  // namespace gonio
