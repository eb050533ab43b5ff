// SPDX-License-Identifier: Apache-2.0
#include "drivers/camera_device.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace gonio {
namespace {

using testing::HasSubstr;

CameraDevice Read(const std::string& text) {
  const ConfigNode root = ConfigNode::Parse("device: " + text, "rig.yaml");
  CameraDevice device = ReadCameraDevice(root.Map("device"));
  root.RefuseUnknownKeys();
  return device;
}

std::string Complaint(const std::string& text) {
  try {
    Read(text);
  } catch (const ConfigError& error) {
    return error.what();
  }
  return "none";
}

TEST(CameraDevice, IsSimulated) {
  EXPECT_EQ(Read("{driver: simulated}").driver, CameraDevice::Driver::kSimulated);
}

TEST(CameraDevice, HasDefaults) {
  const CameraDevice device = Read("{driver: genicam, serial: '123', pixel_format: Mono12}");
  EXPECT_EQ(device.driver, CameraDevice::Driver::kGenicam);
  EXPECT_EQ(device.where, "rig.yaml:1: device");
  EXPECT_EQ(device.genicam.serial, "123");
  EXPECT_EQ(device.genicam.gain_db, 0);
  EXPECT_FALSE(device.genicam.black_level.has_value());
  EXPECT_EQ(device.genicam.retries, 8);
  EXPECT_EQ(device.genicam.discarded_on_change, 1);
  EXPECT_TRUE(device.genicam.chunk_data);
}

TEST(CameraDevice, HasAllThatCanBeSaid) {
  const CameraDevice device = Read(
      "{driver: genicam, address: 192.168.1.20, pixel_format: BayerRG12p, offset_x_px: 8,"
      " offset_y_px: 4, gain_db: 6.5, gain_raw_step_db: 0.0359, black_level_counts: 16,"
      " trigger_line: Line1, packet_size_bytes: 9000, longest_readout_s: 0.02, late_s: 1,"
      " retries: 5, discarded_first: 2, discarded_on_change: 0, chunk_data: false,"
      " reopen_s: 30}");
  const GenicamSettings& settings = device.genicam;
  EXPECT_EQ(settings.address, "192.168.1.20");
  EXPECT_EQ(settings.pixel_format, "BayerRG12p");
  EXPECT_EQ(settings.offset_x, 8);
  EXPECT_EQ(settings.offset_y, 4);
  EXPECT_DOUBLE_EQ(settings.gain_db, 6.5);
  EXPECT_DOUBLE_EQ(settings.gain_raw_step_db, 0.0359);
  EXPECT_EQ(settings.black_level, 16);
  EXPECT_EQ(settings.trigger_line, "Line1");
  EXPECT_EQ(settings.packet_size, 9000);
  EXPECT_DOUBLE_EQ(settings.readout.count(), 0.02);
  EXPECT_DOUBLE_EQ(settings.margin.count(), 1);
  EXPECT_EQ(settings.retries, 5);
  EXPECT_EQ(settings.discarded_first, 2);
  EXPECT_EQ(settings.discarded_on_change, 0);
  EXPECT_FALSE(settings.chunk_data);
  EXPECT_DOUBLE_EQ(settings.reopen_limit.count(), 30);
}

TEST(CameraDevice, ComplainsInOneLine) {
  EXPECT_THAT(Complaint("{driver: genicam, pixel_format: Mono12}"),
              HasSubstr("rig.yaml:1: device.address: is missing; or give serial, or name"));
  EXPECT_THAT(Complaint("{driver: genicam, address: '', pixel_format: Mono12}"),
              HasSubstr("device.address: must not be empty"));
  EXPECT_THAT(Complaint("{driver: genicam, address: 10.0.0.1, serial: a, pixel_format: Mono12}"),
              HasSubstr("device.serial: says twice which camera"));
  EXPECT_THAT(Complaint("{driver: genicam, serial: a, pixel_format: Mono13}"),
              HasSubstr("device.pixel_format"));
  EXPECT_THAT(Complaint("{driver: genicam, serial: a, pixel_format: Mono8, late_s: 0.1}"),
              HasSubstr("device.late_s"));
  EXPECT_THAT(Complaint("{driver: genicam, serial: a, pixel_format: Mono8, gain: 1}"),
              HasSubstr("gain"));
}

}  // namespace
}  // namespace gonio
