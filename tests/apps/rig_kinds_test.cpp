// SPDX-License-Identifier: Apache-2.0
// Every command that meets a rig, on rigs that are not four-axis arms.
#include <nlohmann/json.hpp>

#include "acquisition/session_record.h"
#include "tests/apps/gonio_process.h"

namespace gonio {
namespace {

using nlohmann::json;
using testing::HasSubstr;

constexpr const char* kTurntable = "rig-turntable.yaml";
constexpr const char* kTiltingSample = "rig-tilting-sample.yaml";

class EveryRigKind : public GonioTest, public testing::WithParamInterface<const char*> {};
INSTANTIATE_TEST_SUITE_P(Files, EveryRigKind, testing::Values(kTurntable, kTiltingSample),
                         [](const auto& file) {
                           std::string name = file.param;
                           std::replace(name.begin(), name.end(), '-', '_');
                           return name.substr(0, name.find('.'));
                         });
class TurntableRig : public GonioTest {};
class TiltingSampleRig : public GonioTest {};

TEST_P(EveryRigKind, GoesOnWithASessionReplaysAndReportsIt) {
  const std::string rig = GetParam();
  const Finished full =
      Shell("trap '' XFSZ; ulimit -f 340; \"$GONIO\" run --max-poses 8 --quiet --rig " + rig +
            " --out s");
  ASSERT_EQ(full.code, 1) << full.err;
  const std::size_t before = ReadSession(work() / "s").poses.size();
  ASSERT_GT(before, 1u);
  ASSERT_LT(before, 8u);
  EXPECT_THAT(Expect("run --resume s").out, HasSubstr("8 measured"));
  EXPECT_THAT(Expect("replay s").out, HasSubstr("8: all as logged"));
  EXPECT_THAT(Expect("report s").out, HasSubstr("report.html"));
  EXPECT_THAT(Expect("replay s --plan plan-random.yaml").out, HasSubstr("poses, about"));
}

TEST_P(EveryRigKind, IsSimulatedWithAndWithoutALearnedPrior) {
  const std::string command = fmt::format(
      "simulate --rig {} --plan plan-information.yaml --plan plan-random.yaml "
      "--material satin-paint.yaml --max-poses 40 --quiet --json m.json",
      GetParam());
  for (const char* prior : {"", " --prior " GONIO_SOURCE_DIR "/configs/prior-measured.yaml"}) {
    Expect(command + prior);
    const json result = json::parse(ReadTextFile(work() / "m.json"));
    for (const json& session : result["sessions"]) {
      EXPECT_EQ(session["poses"], 40) << prior;
      EXPECT_EQ(session["rejected"], 0) << prior;
      EXPECT_LT(session["male"], 0.03) << prior;
    }
    EXPECT_GT(result["dense_scan"]["poses"], 1000);
  }
}

TEST_P(EveryRigKind, IsStudied) {
  WriteCoatings();
  File("study.yaml", fmt::format(R"(version: 1
kind: frontier
name: small
materials: ["*.yaml"]
folds: 3
rig: {}
budgets: [12]
noise: [none, default]
targets: [10]
dense_method: continuous
theta_d_stride: 9
phi_stride: 45
contestants:
  - name: chosen
    plan: plan-information.yaml
    prior: plan
    reconstruction: dsbrdf
)",
                                 GetParam()));
  const std::string out = Expect("study study.yaml --materials data --out o").out;
  EXPECT_THAT(out, testing::Not(HasSubstr("failed")));
  const json result = json::parse(ReadTextFile(work() / "o/results.json"));
  EXPECT_EQ(result["cells"].size(), 10u);
  for (const json& cell : result["cells"]) EXPECT_EQ(cell["rows"][0]["poses"], 12);
}

TEST_P(EveryRigKind, HasItsTimesCalibrated) {
  Expect(fmt::format("run --rig {} --max-poses 20 --quiet --out s", GetParam()));
  EXPECT_THAT(Expect("calibrate time s --out cal/time.yaml").out, HasSubstr("camera_arm"));
  File("rig.yaml", Config(GetParam()) + "calibration: {folder: cal}\n");
  EXPECT_THAT(Expect("run --rig rig.yaml --max-poses 3 --quiet --out t").out,
              HasSubstr("3 measured"));
}

TEST_P(EveryRigKind, RefusesAGeometryCalibration) {
  ExpectRefused(
      Gonio(fmt::format("calibrate geometry --rig {} --out cal --target mirror", GetParam())), 2,
      {"geometry.kind: is", "only the geometry of four-axis-arms can be calibrated"});
  std::filesystem::create_directory(work() / "cal");
  File("cal/geometry.yaml", "version: 1\ncamera: simulated\n");
  File("rig.yaml", Config(GetParam()) + "calibration: {folder: cal}\n");
  ExpectRefused(Gonio("run --rig rig.yaml --out s"), 2,
                {"cal/geometry.yaml: is of a rig of four-axis-arms"});
}

TEST_P(EveryRigKind, DoesNotGoOnAsAnother) {
  File("rig.yaml", Config(GetParam()));
  Expect("run --rig rig.yaml --max-poses 3 --quiet --out s");
  File("rig.yaml", Config("sim-rig.yaml"));
  ExpectRefused(Gonio("run --resume s --max-poses 5 --accept-changed"), 2,
                {"rig.yaml: geometry.kind: has other axes than the session's: ", "sample_turn"});
}

// The reachable set of arms in a plane is the half below theta_h + theta_d = 90 deg.
TEST_F(TurntableRig, IsCheckedInItsPlane) {
  const json panels = json::parse(Expect(fmt::format("check {} --json -", kTurntable)).out);
  ASSERT_EQ(panels.size(), 2u);
  EXPECT_EQ(panels[0]["phi_d_deg"], 0);
  EXPECT_EQ(panels[1]["phi_d_deg"], 180);
  for (const json& panel : panels) {
    EXPECT_GT(panel["measurable"], 700);
    EXPECT_EQ(panel["keep_out_by"]["light_arm 1, camera_arm 1"], panel["keep_out"]);
  }
  Expect(fmt::format("check {} --out reach.png", kTurntable));
}

// Across the plane of light and camera it reaches as far as it tilts.
TEST_F(TiltingSampleRig, IsCheckedAtSeveralPhis) {
  const json panels = json::parse(Expect(fmt::format("check {} --json -", kTiltingSample)).out);
  ASSERT_EQ(panels.size(), 3u);
  for (const json& panel : panels) {
    EXPECT_GT(panel["measurable"], 0.6 * panel["poses"].get<int>());
    EXPECT_EQ(panel["cut_off"], 0);
  }
  EXPECT_GT(panels[2]["limits"], panels[0]["limits"]);
}

// A real rig of three axes: their controllers on the wire, the lamp and its monitor on USB.
TEST_F(TurntableRig, HasDoublesOnTheWire) {
  std::string text = Config("bench-wire.yaml");
  const auto begin = text.find("axes:\n");
  text.replace(begin, text.find("motion:\n") - begin, R"(axes:
  light_arm: {min_deg: 2, max_deg: 178, max_speed_deg_s: 20, acceleration_deg_s2: 40, tolerance_deg: 0.05,
              device: {driver: zaber, port: 'usb:BENCH-CHAIN', address: 1}}
  camera_arm: {min_deg: 2, max_deg: 178, max_speed_deg_s: 20, acceleration_deg_s2: 40, tolerance_deg: 0.05,
               device: {driver: zaber, port: 'usb:BENCH-CHAIN', address: 2, turned: true, zero_deg: 178}}
  sample_turn: {min_deg: -180, max_deg: 180, max_speed_deg_s: 20, acceleration_deg_s2: 40, tolerance_deg: 0.05,
                device: {driver: apt, port: 'usb:55000123', stage: K10CR1}}
)");
  File("rig.yaml", With(text, "kind: four-axis-arms", "kind: turntable"));
  const Finished finished = Shell(
      "\"$GONIO\" sim-devices --speed 50 --rig rig.yaml -- \"$GONIO\" run --rig rig.yaml "
      "--max-poses 3 "
      "--quiet --out s");
  ASSERT_EQ(finished.code, 0) << finished.err;
  const SessionRecord record = ReadSession(work() / "s");
  EXPECT_EQ(record.poses.size(), 3u);
  EXPECT_TRUE(record.info.devices.contains("light_arm"));
  EXPECT_FALSE(record.info.devices.contains("light_azimuth"));
}

}  // namespace
}  // namespace gonio
