// SPDX-License-Identifier: Apache-2.0
// Whole sessions on every kind of rig, against the truth.
#include <gmock/gmock.h>

#include "acquisition/event_log.h"
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
