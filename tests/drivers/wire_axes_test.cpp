// SPDX-License-Identifier: Apache-2.0
// Real drivers, over the real serial library, keep the promises of drivers/: their controllers are
// emulated at the other end of a pseudo-terminal.
#include "drivers/serial_port.h"
#include "drivers/zaber_axis.h"
#include "sim/pty_server.h"
#include "sim/zaber_emulator.h"
#include "tests/conformance/axis.h"

namespace gonio {
namespace {

// Members are destroyed last to first: the driver before the line, the line before the device.
AxisSubject ZaberSubject(bool turned) {
  AxisSubject subject;
  subject.clock = std::make_shared<ManualClock>();
  auto stage = std::make_shared<ZaberEmulator>(ZaberStage{}, subject.clock);
  auto line = std::make_shared<PtyServer>(
      [stage](std::string_view bytes) { return stage->Receive(bytes); });
  SerialSettings settings;
  settings.port = line->path();
  auto port = SerialPort::Open(settings);
  EXPECT_TRUE(port.ok()) << port.error().message;
  ControllerAxisSettings axis_settings;
  axis_settings.name = "light_azimuth";
  axis_settings.limits = {.min_position = -2,
                          .max_position = 3,
                          .max_speed = 0.5,
                          .acceleration = 1,
                          .position_tolerance = 1e-4};
  axis_settings.scale.zero = 0.3;
  axis_settings.scale.turned = turned;
  auto axis = zaber::OpenAxis(std::make_shared<zaber::Chain>(std::move(port).value()), {},
                              axis_settings, subject.clock.get());
  EXPECT_TRUE(axis.ok()) << axis.error().message;
  subject.axis = std::move(axis).value();
  subject.shaft = [stage, line, turned] { return 0.3 + (turned ? -1 : 1) * stage->Shaft(); };
  subject.pull_plug = [line] { line->HangUp(); };
  return subject;
}

AxisSubject Zaber() { return ZaberSubject(false); }
AxisSubject ZaberTurned() { return ZaberSubject(true); }

INSTANTIATE_TEST_SUITE_P(Zaber, AxisConformance, testing::Values(Zaber));
INSTANTIATE_TEST_SUITE_P(ZaberTurned, AxisConformance, testing::Values(ZaberTurned));

}  // namespace
}  // namespace gonio
