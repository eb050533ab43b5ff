// SPDX-License-Identifier: Apache-2.0
#include "drivers/axis_device.h"

#include <fmt/format.h>
#include <gmock/gmock.h>

#include "core/units.h"
#include "drivers/axis_opener.h"
#include "sim/wire_bench.h"
#include "tests/core/temp_dir.h"
#include "tests/drivers/wire_axis.h"

namespace gonio {
namespace {

using testing::HasSubstr;

AxisDevice Read(const std::string& text) {
  const ConfigNode root = ConfigNode::Parse(text, "rig.yaml");
  AxisDevice device = ReadAxisDevice(root.Map("device"));
  root.RefuseUnknownKeys();
  return device;
}

std::string Complaint(const std::string& text) {
  try {
    Read(text);
  } catch (const ConfigError& e) {
    return e.what();
  }
  return "";
}

TEST(ReadAxisDevice, KnowsTheLineOfEachProtocol) {
  const AxisDevice zaber = Read("device: {driver: zaber, port: 'usb:A1', address: 2, axis: 3}");
  EXPECT_EQ(zaber.where, "rig.yaml:1: device");
  EXPECT_EQ(zaber.port.port, "usb:A1");
  EXPECT_EQ(zaber.port.baud, 115200);
  EXPECT_EQ(zaber.address, 2);
  EXPECT_EQ(zaber.axis, 3);
  EXPECT_FALSE(zaber.turned);
  const AxisDevice conex =
      Read("device: {driver: conex-cc, port: /dev/ttyUSB0, turned: true, zero_deg: 90}");
  EXPECT_EQ(conex.protocol, AxisProtocol::kSmc100);
  EXPECT_EQ(conex.port.baud, 921600);
  EXPECT_EQ(conex.port.flow, SerialSettings::Flow::kXonXoff);
  EXPECT_TRUE(conex.turned);
  EXPECT_EQ(conex.zero, RadFromDeg(90));
  EXPECT_EQ(Read("device: {driver: smc100, port: a, baud: 9600, flow: none}").port.baud, 9600);
}

TEST(ReadAxisDevice, RefusesWhatNoControllerHas) {
  EXPECT_THAT(Complaint("device: {driver: zabber, port: a}"),
              HasSubstr("rig.yaml:1: device.driver: is \"zabber\", must be one of zaber"));
  EXPECT_THAT(Complaint("device: {driver: zaber}"), HasSubstr("device.port: is missing"));
  EXPECT_THAT(Complaint("device: {driver: smc100, port: a, address: 32}"),
              HasSubstr("device.address: is 32, must be between 1 and 31"));
  EXPECT_THAT(Complaint("device: {driver: smc100, port: a, axis: 2}"), HasSubstr("device.axis"));
  EXPECT_THAT(Complaint("device: {driver: zaber, port: a, bits: 7}"),
              HasSubstr("device.bits: is not a known key"));
}

class AxisOpenerTest : public testing::Test {
 protected:
  AxisOpenerTest() {
    device_.port.port = "line";
    bench_.Add(device_, ArmSettings().limits);
    bench_.Serve();
    device_.port.port = bench_.PathOf(0);
  }

  std::shared_ptr<ManualClock> clock_ = std::make_shared<ManualClock>();
  WireBench bench_{clock_};
  AxisDevice device_;
  AxisOpener opener_{clock_.get(), std::make_shared<LinkLog>(clock_.get())};
};

// Example failure is a second driver on the line that reads the first one's replies.
TEST_F(AxisOpenerTest, SharesALineAndRefusesToOpenItInTwoWays) {
  ASSERT_TRUE(opener_.Open(device_, ArmSettings()).ok());
  EXPECT_TRUE(opener_.Open(device_, ArmSettings()).ok());
  AxisDevice other = device_;
  other.port.baud = 9600;
  const auto slower = opener_.Open(other, ArmSettings());
  ASSERT_FALSE(slower.ok());
  EXPECT_EQ(slower.error().message, "arm: " + device_.port.port +
                                        ": another axis has it with another speed or flow control");
  other = device_;
  other.protocol = AxisProtocol::kSmc100;
  EXPECT_EQ(opener_.Open(other, ArmSettings()).error().message,
            "arm: " + device_.port.port + ": another axis has it for another protocol");
}

TEST_F(AxisOpenerTest, NamesTheAxisWhosePortIsNotThere) {
  device_.port.port = "/dev/gone";
  EXPECT_EQ(opener_.Open(device_, ArmSettings()).error().message,
            "arm: /dev/gone: no such serial port; gonio devices lists those there are");
}

struct Named {
  const char* driver;  // and what it needs in a rig file
  double zero = 0;
};

class EveryDriver : public testing::TestWithParam<Named> {};

// From the rig file to a move. Example failure is a driver that nobody can name.
TEST_P(EveryDriver, OpensAndMovesItsDouble) {
  AxisDevice device = Read(fmt::format("device: {{{}, port: line}}", GetParam().driver));
  device.zero = GetParam().zero;
  auto clock = std::make_shared<ManualClock>();
  WireBench bench(clock);
  bench.Add(device, ArmSettings().limits);
  bench.Serve();
  device.port.port = bench.PathOf(0);
  AxisOpener opener(clock.get(), std::make_shared<LinkLog>(clock.get()));
  ControllerAxisSettings settings = ArmSettings();
  settings.limits.position_tolerance = 1e-3;
  const auto axis = opener.Open(device, settings);
  ASSERT_TRUE(axis.ok()) << axis.error().message;
  ASSERT_TRUE((*axis)->Home({}).ok());
  ASSERT_TRUE((*axis)->StartMove(1.5).ok());
  ASSERT_TRUE((*axis)->WaitUntilStill(Seconds(60), {}).ok());
  EXPECT_NEAR(bench.Angle(0), 1.5, 1e-3);
}

INSTANTIATE_TEST_SUITE_P(
    Axes, EveryDriver,
    testing::Values(Named{"driver: zaber"}, Named{"driver: smc100"}, Named{"driver: conex-cc"},
                    Named{"driver: esp301, axis: 2"}, Named{"driver: apt, stage: PRM1-Z8"},
                    Named{"driver: apt, stage: K10CR1"}, Named{"driver: apt, stage: DDR100"},
                    Named{"driver: apt, stage: DDR05"},
                    Named{"driver: apt, stage: HDR50, address: 2"},
                    Named{"driver: apt, stage: NR360"}, Named{"driver: gcs2"},
                    Named{"driver: gcs2, address: 3"}, Named{"driver: grbl, axis: 2", 2.6}));

// A cable in the wrong socket. Example failure is a driver that opens whatever answers.
TEST_F(AxisOpenerTest, RefusesAnotherKindOfController) {
  device_.protocol = AxisProtocol::kSmc100;
  const auto axis = opener_.Open(device_, ArmSettings());
  ASSERT_FALSE(axis.ok());
  EXPECT_EQ(axis.error().code, ErrorCode::kTimeout) << axis.error().message;
}

}  // namespace
}  // namespace gonio
