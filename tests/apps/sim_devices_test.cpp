// SPDX-License-Identifier: Apache-2.0
// A whole session of the program as it is shipped, in a process of its own, on doubles that it
// finds behind libserialport and libusb.

#include <cmath>
#include <sstream>

#include "acquisition/session_frames.h"
#include "acquisition/session_record.h"
#include "core/config.h"
#include "core/file.h"
#include "core/sha256.h"
#include "core/units.h"
#include "tests/apps/gonio_process.h"
#include "tests/genicam/own_network.h"

namespace gonio {
namespace {

using testing::HasSubstr;
using testing::StartsWith;

constexpr const char* kGrey = R"(version: 1
name: grey
layers:
  - {kind: lambert, albedo: [0.2, 0.4, 0.6]}
)";

class SimDevices : public GonioTest {
 protected:
  Finished OnBench(const std::string& rig, const std::string& command) {
    return Shell("\"$GONIO\" sim-devices --speed 50 --rig " + rig + " -- " + command);
  }
};

// The light and the monitor of a bench, by colours.
std::string WithLeds(std::string rig) {
  const auto put = [&](const std::string& old, const std::string& now) {
    const auto at = rig.find(old);
    ASSERT_NE(at, std::string::npos) << old;
    rig.replace(at, old.size(), now);
  };
  put("device: {driver: dc2200, usb_serial: M00412345, full_current_a: 0.7}",
      "device: {driver: dc4100, port: 'usb:LEDS', full_currents_a: [0.7, 0.5, 0.35]}\n"
      "  colours: {red: 3, green: 0, blue: 1}");
  put("wavelength_nm: 550, averaging: 10,\n           reference_w: 0.8e-3}",
      "averaging: 10, colours: {red: {wavelength_nm: 625, reference_w: 1.0e-3}, "
      "green: {wavelength_nm: 530, reference_w: 0.5e-3}, "
      "blue: {wavelength_nm: 470, reference_w: 2.0e-3}}}");
  return rig;
}

// The messages that wire.log shows, by link.
std::map<std::string, long> SentIn(const std::string& log) {
  std::map<std::string, long> sent;
  std::istringstream lines(log);
  for (std::string line; std::getline(lines, line);) {
    std::istringstream words(line);
    std::string time, link, word;
    words >> time >> link >> word;
    // An instrument's name has three words.
    while (link.substr(0, 3) == "USB" && word.size() > 1 && words) {
      link += " " + word;
      words >> word;
    }
    if (word == ">") ++sent[link];
  }
  return sent;
}

// The camera's port is one per network: a network of its own for the double, its program and this
// process, or turns.
class SimCameraDevices : public SimDevices {
 protected:
  static void SetUpTestSuite() {
    static const bool once = (EnterOwnNetwork(), true);
    (void)once;
  }
  // Each frame of the session in ./session as the double sent it.
  void ExpectOnlyFramesThatWereSent() {
    const std::string sent = ReadTextFile(work() / "frames.log");
    SessionFrames frames(work() / "session");
    const int poses = static_cast<int>(ReadSession(work() / "session").poses.size());
    for (int pose = 1; pose <= poses; ++pose) {
      for (const Exposure& exposure : frames.Of(pose)) {
        const auto& counts = exposure.frame.counts;
        const std::string_view bytes(reinterpret_cast<const char*>(counts.data()),
                                     counts.size() * sizeof counts[0]);
        EXPECT_THAT(sent, HasSubstr(Sha256(bytes))) << pose;
      }
    }
  }
};

// Real serial lines, a real USB stack and real GigE Vision packets. The program knows nothing of
// the sample: only the double of the camera sees it.
TEST_F(SimCameraDevices, ASessionWithACameraMeasuresTheSample) {
  File("grey.yaml", kGrey);
  const Finished finished =
      OnBench("bench-camera.yaml --material grey.yaml",
              "\"$GONIO\" run --rig bench-camera.yaml --max-poses 4 --out session");
  ASSERT_EQ(finished.code, 0) << finished.err;
  EXPECT_THAT(finished.out, testing::Not(HasSubstr("MALE")));
  const SessionRecord record = ReadSession(work() / "session");
  EXPECT_THAT(record.info.devices.at("camera"), HasSubstr("GigE double, serial GP0001"));
  EXPECT_EQ(record.info.material_path, "");
  ASSERT_EQ(record.poses.size(), 4u);
  for (const MeasuredPose& pose : record.poses) {
    const BrdfSample& sample = pose.samples.front();
    const Rgb miss = (sample.f_r - Rgb(0.2, 0.4, 0.6) / kPi) / sample.sigma;
    EXPECT_LT(miss.abs().maxCoeff(), 5) << sample.f_r;
  }
}

// A mono camera that sees one LED at a time, each with a monitor reading of its own.
TEST_F(SimCameraDevices, ASessionWithAMonoCameraMeasuresInThreeColours) {
  File("grey.yaml", kGrey);
  std::string rig =
      With(Config("bench-camera.yaml"), "pixel_format: BayerRG12", "pixel_format: Mono12");
  rig = With(rig, "layout: bayer-rg", "layout: mono");
  File("rig.yaml", WithLeds(rig));
  const Finished finished = OnBench(
      "rig.yaml --material grey.yaml",
      "sh -c '\"$GONIO\" doctor --rig rig.yaml; \"$GONIO\" run --rig rig.yaml --max-poses 3 "
      "--out session'");
  ASSERT_EQ(finished.code, 0) << finished.err;
  EXPECT_THAT(finished.out, HasSubstr("usb:LEDS"));
  const SessionRecord record = ReadSession(work() / "session");
  ASSERT_EQ(record.poses.size(), 3u);
  for (const MeasuredPose& pose : record.poses) {
    const BrdfSample& sample = pose.samples.front();
    const Rgb miss = (sample.f_r - Rgb(0.2, 0.4, 0.6) / kPi) / sample.sigma;
    EXPECT_LT(miss.abs().maxCoeff(), 5) << sample.f_r;
  }
}

// Example failure is a frame with a hole in a sample, or a session that ends at the first of them.
TEST_F(SimCameraDevices, ASessionGetsOverLostPackets) {
  File("grey.yaml", kGrey);
  const Finished finished = OnBench(
      "bench-camera.yaml --material grey.yaml --packet-loss-percent 2 --frames-log frames.log",
      "\"$GONIO\" run --rig bench-camera.yaml --max-poses 6 --out session");
  ASSERT_EQ(finished.code, 0) << finished.err;
  EXPECT_EQ(ReadSession(work() / "session").poses.size(), 6u);
  ExpectOnlyFramesThatWereSent();
}

// Twice as late as the default without chunk data allows for. Example failure is a sample that is
// too bright because its frame had the exposure before.
TEST_F(SimCameraDevices, ASessionTakesNoFrameForOneOfAnotherExposure) {
  File("grey.yaml", kGrey);
  const Finished finished = OnBench(
      "bench-camera.yaml --material grey.yaml --camera-late-frames 2 --camera-chunk-data "
      "--frames-log frames.log",
      "\"$GONIO\" run --rig bench-camera.yaml --max-poses 4 --out session");
  ASSERT_EQ(finished.code, 0) << finished.err;
  EXPECT_THAT(finished.out, HasSubstr(" that were taken with earlier settings"));
  EXPECT_THAT(finished.out, testing::Not(HasSubstr(" 0 that were taken with earlier settings")));
  ExpectOnlyFramesThatWereSent();
  const SessionRecord record = ReadSession(work() / "session");
  ASSERT_EQ(record.poses.size(), 4u);
  for (const MeasuredPose& pose : record.poses) {
    const BrdfSample& sample = pose.samples.front();
    const Rgb miss = (sample.f_r - Rgb(0.2, 0.4, 0.6) / kPi) / sample.sigma;
    EXPECT_LT(miss.abs().maxCoeff(), 5) << sample.f_r;
  }
}

TEST_F(SimCameraDevices, ASessionGoesOnWhenItsCameraComesBack) {
  File("grey.yaml", kGrey);
  const Finished finished = OnBench(
      "bench-camera.yaml --material grey.yaml --camera-gone-after 3 --camera-gone-for-s 1 "
      "--frames-log frames.log",
      "\"$GONIO\" run --rig bench-camera.yaml --max-poses 6 --out session");
  ASSERT_EQ(finished.code, 0) << finished.err;
  EXPECT_THAT(finished.out, HasSubstr("lost and found 1 times"));
  EXPECT_EQ(ReadSession(work() / "session").poses.size(), 6u);
  ExpectOnlyFramesThatWereSent();
}

// Example failure is a session that loses what it has, or waits for ever.
TEST_F(SimCameraDevices, ASessionEndsWholeWhenItsCameraStaysAway) {
  File("grey.yaml", kGrey);
  File("rig.yaml", With(Config("bench-camera.yaml"), "black_level_counts: 64",
                        "black_level_counts: 64, reopen_s: 1") +
                       "failures: {instrument: {retries: 1, wait_s: 0.1}}\n");
  const Finished finished = OnBench("rig.yaml --material grey.yaml --camera-gone-after 3",
                                    "\"$GONIO\" run --rig rig.yaml --max-poses 6 --out session");
  EXPECT_EQ(finished.code, 4) << finished.err;
  EXPECT_THAT(finished.err, HasSubstr("the camera was lost and not found again"));
  const SessionRecord record = ReadSession(work() / "session");
  EXPECT_GE(record.poses.size(), 1u);
  EXPECT_LT(record.poses.size(), 6u);
}

// Away for longer than its driver looks for it: the session opens it anew, and the light and the
// monitor with it. Example failure is a port that is still held by the driver that gave up.
TEST_F(SimCameraDevices, ASessionOpensItsCameraAnew) {
  File("grey.yaml", kGrey);
  File("rig.yaml", With(Config("bench-camera.yaml"), "black_level_counts: 64",
                        "black_level_counts: 64, reopen_s: 1") +
                       "failures: {instrument: {retries: 30, wait_s: 0.5}, max_in_a_row: 100}\n");
  const Finished finished =
      OnBench("rig.yaml --material grey.yaml --camera-gone-after 3 --camera-gone-for-s 28",
              "\"$GONIO\" run --rig rig.yaml --max-poses 6 --out session "
              "--notify 'cat >> notices'");
  ASSERT_EQ(finished.code, 0) << finished.err;
  const SessionRecord record = ReadSession(work() / "session");
  EXPECT_EQ(record.poses.size(), 6u);
  const std::string notices = ReadTextFile(work() / "notices");
  EXPECT_THAT(notices, HasSubstr(R"("kind":"failure")"));
  EXPECT_THAT(notices, HasSubstr("the camera was lost and not found again"));
  EXPECT_THAT(notices, HasSubstr(R"("kind":"recovered")"));
  EXPECT_THAT(notices, HasSubstr(R"("kind":"session_end")"));
}

TEST_F(SimDevices, RefusesTroubleForACameraThatIsNotThere) {
  for (const char* option : {"--packet-loss-percent 1", "--camera-gone-after 3",
                             "--camera-late-frames 1", "--camera-chunk-data", "--frames-log f"}) {
    ExpectRefused(OnBench(std::string("bench-wire.yaml ") + option, "true"), 2,
                  {"the camera of bench-wire.yaml is simulated by the command itself"});
  }
}

// The steps work on real drivers, too. Example failure: a light that is on while darks are taken.
TEST_F(SimCameraDevices, ACameraIsCalibrated) {
  std::string rig = With(Config("bench-camera.yaml"), "max_exposure_s: 10", "max_exposure_s: 0.5");
  rig = With(rig, "soft_limit_s: 1 ", "soft_limit_s: 0.5 ");
  File("rig.yaml", rig);
  File("steps.sh",
       "set -e\n"
       "\"$GONIO\" calibrate darks --rig rig.yaml --out cal --frames 4 --quiet\n"
       "\"$GONIO\" calibrate photon-transfer --rig rig.yaml --out cal --frames 2 --quiet\n"
       "\"$GONIO\" calibrate status --rig rig.yaml --out cal\n");
  const Finished finished = OnBench("rig.yaml --material ptfe.yaml", "sh steps.sh");
  ASSERT_EQ(finished.code, 0) << finished.err;
  EXPECT_THAT(finished.out, HasSubstr("GigE double, serial GP0001"));
  const ConfigNode dark = ConfigNode::Load(work() / "cal/dark.yaml").Map("estimates");
  EXPECT_NEAR(std::sqrt(dark.Numbers("dark0_read_variance_counts2", 2)[0]), 8.0 / 4, 0.1);
  const ConfigNode sensor = ConfigNode::Load(work() / "cal/photon-transfer.yaml").Map("estimates");
  const auto gain = sensor.Numbers("gain_e_per_count", 2);
  EXPECT_NEAR(gain[0], 4, 5 * gain[1]);
  EXPECT_LT(gain[1], 0.1);
}

TEST_F(SimDevices, ASessionOverTheWiresMeasuresTheSample) {
  File("grey.yaml", kGrey);
  const Finished finished = OnBench(
      "bench-wire.yaml",
      "\"$GONIO\" run --rig bench-wire.yaml --material grey.yaml --max-poses 4 --out session");
  ASSERT_EQ(finished.code, 0) << finished.err;
  const SessionRecord record = ReadSession(work() / "session");
  ASSERT_EQ(record.poses.size(), 4u);
  for (const MeasuredPose& pose : record.poses) {
    const Rgb miss =
        (pose.samples.front().f_r - Rgb(0.2, 0.4, 0.6) / kPi) / pose.samples.front().sigma;
    EXPECT_LT(miss.abs().maxCoeff(), 5) << pose.samples.front().f_r;
  }
  const auto& devices = record.info.devices;
  EXPECT_THAT(devices.at("light_azimuth"), StartsWith("Zaber device 50081"));
  EXPECT_THAT(devices.at("camera_azimuth"), HasSubstr("K10CR1"));
  EXPECT_THAT(devices.at("light"), HasSubstr("DC2200"));
  EXPECT_THAT(devices.at("monitor"), HasSubstr("PM100D"));
}

// A light on a serial line, and another stage. Example failure is a bench without one of the
// devices that rig files may name.
TEST_F(SimDevices, HasADoubleOfEveryLight) {
  File("grey.yaml", kGrey);
  std::string rig = ReadTextFile(std::string(GONIO_SOURCE_DIR) + "/configs/bench-wire.yaml");
  const auto put = [&](const std::string& old, const std::string& now) {
    const auto at = rig.find(old);
    ASSERT_NE(at, std::string::npos) << old;
    rig = rig.substr(0, at) + now + rig.substr(at + old.size());
  };
  put("driver: dc2200, usb_serial: M00412345", "driver: dc4100, port: 'usb:LEDS', channel: 2");
  put("'usb:55000123', stage: K10CR1", "'usb:28000042', stage: DDR100");
  File("rig.yaml", rig);
  const Finished finished = OnBench(
      "rig.yaml", "\"$GONIO\" run --rig rig.yaml --material grey.yaml --max-poses 2 --out s");
  ASSERT_EQ(finished.code, 0) << finished.err;
  const auto devices = ReadSession(work() / "s").info.devices;
  EXPECT_THAT(devices.at("light"), HasSubstr("DC4100"));
  EXPECT_THAT(devices.at("camera_azimuth"), HasSubstr("KBD101"));
}

// Three LEDs before a mono camera, and a meter that is set to each one's wavelength.
TEST_F(SimDevices, ASessionInThreeColoursMeasuresTheSample) {
  File("grey.yaml", kGrey);
  File("rig.yaml",
       WithLeds(With(Config("bench-wire.yaml"), "camera:\n", "camera:\n  layout: mono\n")));
  const Finished finished = OnBench(
      "rig.yaml", "\"$GONIO\" run --rig rig.yaml --material grey.yaml --max-poses 4 --out session");
  ASSERT_EQ(finished.code, 0) << finished.err;
  const SessionRecord record = ReadSession(work() / "session");
  ASSERT_EQ(record.poses.size(), 4u);
  for (const MeasuredPose& pose : record.poses) {
    const Rgb miss =
        (pose.samples.front().f_r - Rgb(0.2, 0.4, 0.6) / kPi) / pose.samples.front().sigma;
    EXPECT_LT(miss.abs().maxCoeff(), 5) << pose.samples.front().f_r;
  }
  EXPECT_THAT(record.info.devices.at("light"), HasSubstr("; green channel 0: LED"));
  EXPECT_THAT(record.info.devices.at("monitor"), HasSubstr("625 / 530 / 470 nm"));
  for (const char* colour : {"red", "green", "blue"}) {
    EXPECT_GE(record.frames_by_colour.at(colour), 4) << colour;
  }
}

// On the line of the arms' stages.
TEST_F(SimDevices, ASessionWithAFilterWheelMeasuresTheSample) {
  File("grey.yaml", kGrey);
  std::string rig =
      With(Config("bench-wire.yaml"), "  device: {driver: dc2200",
           "  filter_wheel: {min_deg: -5, max_deg: 355, max_speed_deg_s: 90, acceleration_deg_s2: "
           "180, tolerance_deg: 0.1, positions_deg: {red: 0, green: 120, blue: 240},\n    device: "
           "{driver: zaber, port: 'usb:BENCH-CHAIN', address: 3}}\n  device: {driver: dc2200");
  rig = With(rig, "camera:\n", "camera:\n  layout: mono\n");
  File("rig.yaml", rig);
  const Finished finished = OnBench(
      "rig.yaml", "\"$GONIO\" run --rig rig.yaml --material grey.yaml --max-poses 3 --out session");
  ASSERT_EQ(finished.code, 0) << finished.err;
  const SessionRecord record = ReadSession(work() / "session");
  ASSERT_EQ(record.poses.size(), 3u);
  for (const MeasuredPose& pose : record.poses) {
    const Rgb miss =
        (pose.samples.front().f_r - Rgb(0.2, 0.4, 0.6) / kPi) / pose.samples.front().sigma;
    EXPECT_LT(miss.abs().maxCoeff(), 5) << pose.samples.front().f_r;
  }
  EXPECT_THAT(record.info.devices.at("light"),
              HasSubstr("filters red at 0, green at 120, blue at 240 deg of Zaber device 50081"));
}

TEST_F(SimDevices, EveryExchangeIsInTheLog) {
  File("grey.yaml", kGrey);
  ASSERT_EQ(OnBench("bench-wire.yaml",
                    "\"$GONIO\" run --rig bench-wire.yaml --material grey.yaml --max-poses 2 --out "
                    "session")
                .code,
            0);
  const auto sent = SentIn(ReadTextFile(work() / "session" / "wire.log"));
  EXPECT_EQ(sent.size(), 5u);
  int links = 0;
  for (const SessionEvent& event : ReadSession(work() / "session").events) {
    if (event.kind != "wire") continue;
    ++links;
    EXPECT_THAT(event.body, HasSubstr("0 calls failed"));
    const bool found = std::any_of(sent.begin(), sent.end(), [&](const auto& link) {
      const auto begin = link.first + ": " + std::to_string(link.second) + " messages sent";
      return event.body.find(begin) != std::string::npos;
    });
    EXPECT_TRUE(found) << event.body;
  }
  EXPECT_EQ(links, 5);
}

TEST_F(SimDevices, ADeviceThatIsNotThereIsNamedBeforeAnythingMoves) {
  std::string rig = ReadTextFile(std::string(GONIO_SOURCE_DIR) + "/configs/bench-wire.yaml");
  const std::string right = "usb_serial: M00412345";
  rig.replace(rig.find(right), right.size(), std::string("usb_serial: M00499999"));
  File("other.yaml", rig);
  const Finished finished =
      OnBench("bench-wire.yaml", "\"$GONIO\" run --rig other.yaml --max-poses 2 --out session");
  ExpectRefused(finished, 2,
                {"other.yaml:", "light.device", "M00499999: not plugged in", "M00412345"});
  EXPECT_FALSE(std::filesystem::exists(work() / "session"));
}

TEST_F(SimDevices, AreListed) {
  const std::string list = OnBench("bench-wire.yaml", "\"$GONIO\" devices").out;
  EXPECT_THAT(list, HasSubstr("usb:BENCH-CHAIN"));
  EXPECT_THAT(list, HasSubstr("1313:80c8        M00412345            DC2200"));
  EXPECT_THAT(list, HasSubstr("1313:8078        P0012345             PM100D"));
}

TEST_F(SimDevices, PassesOnWhatTheCommandEndedWith) {
  EXPECT_EQ(OnBench("bench-wire.yaml", "sh -c 'exit 7'").code, 7);
  ExpectRefused(OnBench("sim-rig.yaml", "true"), 2, {"is a simulated rig"});
  ExpectRefused(OnBench("bench-wire.yaml", "no-such-command"), 1,
                {"no-such-command: cannot be started"});
}

}  // namespace
}  // namespace gonio
