// SPDX-License-Identifier: Apache-2.0
// What users do with a mono camera and three LEDs.

#include "acquisition/session_frames.h"
#include "acquisition/session_record.h"
#include "core/config.h"
#include "core/units.h"
#include "tests/apps/gonio_process.h"

namespace gonio {
namespace {

using testing::AllOf;
using testing::HasSubstr;

constexpr const char* kColoured = R"(version: 1
name: coloured
layers:
  - {kind: lambert, albedo: [0.2, 0.4, 0.6]}
)";

class Colours : public GonioTest {};

TEST_F(Colours, AreMeasuredReportedExportedAndReplayed) {
  File("paint.yaml", kColoured);
  Expect("run --rig sim-rig-leds.yaml --material paint.yaml --max-poses 6 --out s");
  const SessionRecord record = ReadSession(work() / "s");
  ASSERT_EQ(record.poses.size(), 6u);
  EXPECT_EQ(record.info.devices.at("light"), "simulated, red, green and blue");
  for (const MeasuredPose& pose : record.poses) {
    const BrdfSample& sample = pose.samples.front();
    const Rgb miss = (sample.f_r - Rgb(0.2, 0.4, 0.6) / kPi) / sample.sigma;
    EXPECT_LT(miss.abs().maxCoeff(), 5) << sample.f_r;
  }
  EXPECT_THAT(Expect("replay s --rereduce").out, HasSubstr("all as logged"));
  Expect("report s --out r.html");
  EXPECT_THAT(ReadTextFile(work() / "r.html"),
              AllOf(HasSubstr("one colour after the other: "), HasSubstr(" in green, ")));
  Expect("export s --frames f");
  const auto colour = [&](const char* file) {
    return ConfigNode::Load(work() / "f/pose-0001" / file).Text("colour");
  };
  EXPECT_EQ(colour("frame-01.yaml"), "red");
  const std::vector<Exposure> last = SessionFrames(work() / "s").Of(1);
  EXPECT_EQ(last.back().colour, LightColour::kBlue);
}

// Stopped by a full disk.
TEST_F(Colours, ASessionGoesOn) {
  File("paint.yaml", kColoured);
  const Finished full = Shell(
      "trap '' XFSZ; ulimit -f 340; \"$GONIO\" run --rig sim-rig-leds.yaml --material paint.yaml "
      "--max-poses 8 --quiet --out s");
  ASSERT_EQ(full.code, 1) << full.err;
  ASSERT_LT(ReadSession(work() / "s").poses.size(), 8u);
  Expect("run --resume s");
  EXPECT_EQ(ReadSession(work() / "s").poses.size(), 8u);
  EXPECT_THAT(Expect("replay s").out, HasSubstr("8: all as logged"));
}

TEST_F(Colours, ArePartOfACalibration) {
  std::string rig = With(Config("sim-imperfect.yaml"), "  level: 1.0 ",
                         "  colours: {red: 0, green: 1, blue: 2}\n  level: 1.0 ");
  rig = With(rig, "camera:\n", "camera:\n  layout: mono\n");
  File("leds.yaml", rig);
  for (const char* step : {"darks", "photon-transfer", "flat", "stray-light"}) {
    Expect(fmt::format("calibrate {} --rig leds.yaml --out cal --quiet", step));
  }
  Expect("calibrate standard --rig leds.yaml --out cal --quiet --standard standard-ptfe.yaml");
  EXPECT_THAT(Expect("calibrate status --rig leds.yaml --out cal").out, HasSubstr("pattern"));
  File("paint.yaml", kColoured);
  Expect("run --rig leds.yaml --calibration cal --material paint.yaml --max-poses 3 --out s");
  Expect("replay s --rereduce");
  // Of these LEDs, and of no white light.
  ExpectRefused(Gonio("run --rig sim-imperfect.yaml --calibration cal --max-poses 3 --out t"), 2,
                {"pixel layout is rgb, calibrated for mono"});
  File("mono.yaml", With(Config("sim-imperfect.yaml"), "camera:\n", "camera:\n  layout: mono\n"));
  ExpectRefused(Gonio("run --rig mono.yaml --calibration cal --max-poses 3 --out t"), 2,
                {"flat-field.yaml: light is one without colours, calibrated for simulated, red"});
}

}  // namespace
}  // namespace gonio
