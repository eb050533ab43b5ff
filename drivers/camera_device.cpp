// SPDX-License-Identifier: Apache-2.0
#include "drivers/camera_device.h"

#include <utility>
#include <vector>

#include "core/check.h"
#include "drivers/pixel_unpacking.h"

namespace gonio {
namespace {

void ReadWhichCamera(const ConfigNode& node, GenicamSettings& settings) {
  settings.address = node.TextOr("address", "");
  settings.serial = node.TextOr("serial", "");
  settings.device_id = node.TextOr("name", "");
  const int ways =
      !settings.address.empty() + !settings.serial.empty() + !settings.device_id.empty();
  if (ways == 0) node.Fail("address", "is missing; or give serial, or name");
  if (ways > 1) node.Fail(node.Has("name") ? "name" : "serial", "says twice which camera is meant");
}

}  // namespace

CameraDevice ReadCameraDevice(const ConfigNode& node) {
  CameraDevice device;
  device.where = node.Where();
  if (node.Choice("driver", {"simulated", "genicam"}) == "simulated") return device;
  device.driver = CameraDevice::Driver::kGenicam;
  GenicamSettings& settings = device.genicam;
  ReadWhichCamera(node, settings);
  std::vector<std::string> formats;
  for (const PixelFormat& format : KnownPixelFormats()) formats.push_back(format.name);
  settings.pixel_format = node.Choice("pixel_format", formats);
  settings.offset_x = node.IntegerOr("offset_x_px", 0, 0, 65535);
  settings.offset_y = node.IntegerOr("offset_y_px", 0, 0, 65535);
  settings.gain_db = node.NumberOr("gain_db", 0);
  settings.gain_raw_step_db = node.NumberOr("gain_raw_step_db", 0, Range::NonNegative());
  if (node.Has("black_level_counts")) {
    settings.black_level = node.Number("black_level_counts", Range::NonNegative());
  }
  settings.trigger_line = node.TextOr("trigger_line", "");
  settings.packet_size = node.IntegerOr("packet_size_bytes", 0, 0, 65535);
  settings.readout =
      Seconds(node.NumberOr("longest_readout_s", settings.readout.count(), Range::NonNegative()));
  settings.margin =
      Seconds(node.NumberOr("late_s", settings.margin.count(), Range::Between(0.3, 60)));
  settings.retries = node.IntegerOr("retries", settings.retries, 0, 100);
  settings.discarded_first = node.IntegerOr("discarded_first", settings.discarded_first, 0, 100);
  settings.discarded_on_change =
      node.IntegerOr("discarded_on_change", settings.discarded_on_change, 0, 100);
  settings.chunk_data = node.BoolOr("chunk_data", settings.chunk_data);
  settings.reopen_limit =
      Seconds(node.NumberOr("reopen_s", settings.reopen_limit.count(), Range::Between(0, 3600)));
  return device;
}

Result<std::unique_ptr<Camera>> OpenCamera(const CameraDevice& device, const std::string& name,
                                           int width, int height, Clock& clock) {
  GONIO_CHECK(device.driver == CameraDevice::Driver::kGenicam,
              "simulated cameras are opened elsewhere");
  GenicamSettings settings = device.genicam;
  settings.name = name;
  settings.width = width;
  settings.height = height;
  auto camera = GenicamCamera::Open(settings, clock);
  if (!camera) return camera.error();
  return std::unique_ptr<Camera>(std::move(camera).value());
}

}  // namespace gonio
