// SPDX-License-Identifier: Apache-2.0
// Real drivers, over the real serial library, keep the promises of drivers/: their controllers are
// emulated at the other end of a pseudo-terminal.
#include "drivers/serial_port.h"
#include "drivers/smc100_axis.h"
#include "drivers/zaber_axis.h"
#include "sim/pty_server.h"
#include "sim/smc100_emulator.h"
#include "sim/zaber_emulator.h"
#include "tests/conformance/axis.h"

namespace gonio {
namespace {

std::unique_ptr<SerialPort> Opened(const PtyServer& line) {
  SerialSettings settings;
  settings.port = line.path();
  auto port = SerialPort::Open(settings);
  EXPECT_TRUE(port.ok()) << port.error().message;
  return std::move(port).value();
}

ControllerAxisSettings Settings(bool turned) {
  ControllerAxisSettings settings;
  settings.name = "light_azimuth";
  settings.limits = {.min_position = -2,
                     .max_position = 2.5,
                     .max_speed = 0.5,
                     .acceleration = 1,
                     .position_tolerance = 1e-4};
  settings.scale.zero = 0.3;
  settings.scale.turned = turned;
  return settings;
}

// Members are destroyed last to first: the driver before the line, the line before the device.
template <typename Emulator>
AxisSubject Subject(std::shared_ptr<Emulator> stage, std::shared_ptr<ManualClock> clock,
                    bool turned, auto open) {
  AxisSubject subject;
  subject.clock = clock;
  auto line = std::make_shared<PtyServer>(
      [stage](std::string_view bytes) { return stage->Receive(bytes); });
  auto axis = open(Opened(*line), Settings(turned), clock.get());
  EXPECT_TRUE(axis.ok()) << axis.error().message;
  subject.axis = std::move(axis).value();
  subject.shaft = [stage, line, turned] { return 0.3 + (turned ? -1 : 1) * stage->Shaft(); };
  subject.pull_plug = [line] { line->HangUp(); };
  return subject;
}

AxisSubject ZaberSubject(bool turned) {
  auto clock = std::make_shared<ManualClock>();
  return Subject(std::make_shared<ZaberEmulator>(ZaberStage{}, clock), clock, turned,
                 [](std::unique_ptr<ByteLink> link, const auto& settings, Clock* time) {
                   return zaber::OpenAxis(std::make_shared<zaber::Chain>(std::move(link)), {},
                                          settings, time);
                 });
}

AxisSubject Smc100Subject(bool turned) {
  auto clock = std::make_shared<ManualClock>();
  return Subject(std::make_shared<Smc100Emulator>(Smc100Stage{}, clock), clock, turned,
                 [](std::unique_ptr<ByteLink> link, const auto& settings, Clock* time) {
                   return smc100::OpenAxis(std::make_shared<smc100::Line>(std::move(link)), 1,
                                           settings, time);
                 });
}

AxisSubject Zaber() { return ZaberSubject(false); }
AxisSubject ZaberTurned() { return ZaberSubject(true); }
AxisSubject Smc100() { return Smc100Subject(false); }
AxisSubject Smc100Turned() { return Smc100Subject(true); }

INSTANTIATE_TEST_SUITE_P(Zaber, AxisConformance, testing::Values(Zaber));
INSTANTIATE_TEST_SUITE_P(ZaberTurned, AxisConformance, testing::Values(ZaberTurned));
INSTANTIATE_TEST_SUITE_P(Smc100, AxisConformance, testing::Values(Smc100));
INSTANTIATE_TEST_SUITE_P(Smc100Turned, AxisConformance, testing::Values(Smc100Turned));

}  // namespace
}  // namespace gonio
