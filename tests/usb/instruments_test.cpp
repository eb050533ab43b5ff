// SPDX-License-Identifier: Apache-2.0
// Lights and monitors over the real libusb and libserialport, with doubles at the other end.
#include <gmock/gmock.h>

#include "drivers/dc2200_light.h"
#include "drivers/dc4100_light.h"
#include "drivers/thorlabs_monitor.h"
#include "sim/dc4100_emulator.h"
#include "sim/pty_server.h"
#include "sim/scpi_instruments.h"
#include "tests/conformance/light.h"
#include "tests/conformance/monitor.h"
#include "tests/drivers/wire_axis.h"
#include "tests/usb/usb_instrument.h"

namespace gonio {
namespace {

using testing::HasSubstr;

constexpr double kFullCurrent = 0.7;  // A
constexpr double kReference = 1e-3;   // W

// An instrument that answers lines, plugged in.
template <typename Emulator>
struct Plugged {
  template <typename... Arguments>
  explicit Plugged(int product, Arguments... arguments)
      : emulator(arguments...), device(PlateOf(product, "S1"), [this](std::string_view line) {
          return emulator.Receive(line);
        }) {
    bench.Plug(&device);
  }
  std::unique_ptr<MessageLink> Open() { return OpenedDevice(device.plate()); }

  Emulator emulator;
  UsbtmcEmulator device;
  UsbBench bench;
};

Dc2200Settings LightSettings() {
  Dc2200Settings settings;
  settings.name = "light";
  settings.full_current = kFullCurrent;
  return settings;
}

ThorlabsMonitorSettings MeterSettings() {
  ThorlabsMonitorSettings settings;
  settings.name = "monitor";
  settings.wavelength_nm = 550;
  settings.averaging = 10;
  settings.reference = kReference;
  return settings;
}

LightSubject Dc2200() {
  auto plugged = std::make_shared<Plugged<Dc2200Emulator>>(0x80c8);
  auto light = Dc2200Light::Open(plugged->Open(), LightSettings());
  EXPECT_TRUE(light.ok()) << light.error().message;
  LightSubject subject;
  subject.light = std::move(light).value();
  subject.emitted = [plugged] { return plugged->emulator.Current() / kFullCurrent; };
  subject.turn_by_hand = [plugged](double level) {
    plugged->emulator.TurnByHand(level * kFullCurrent);
  };
  return subject;
}

// A driver of four LEDs on a serial line.
struct SerialLight {
  Dc4100Emulator emulator;
  PtyServer line{[this](std::string_view bytes) { return emulator.Receive(bytes); }};
};

LightSubject Dc4100() {
  auto driver = std::make_shared<SerialLight>();
  Dc4100Settings settings;
  settings.name = "light";
  settings.channel = 2;
  settings.full_current = kFullCurrent;
  settings.reply_limit = kWireReplyLimit;
  auto light = Dc4100Light::Open(OpenedPort(driver->line), settings);
  EXPECT_TRUE(light.ok()) << light.error().message;
  LightSubject subject;
  subject.light = std::move(light).value();
  subject.emitted = [driver] { return driver->emulator.Current(2) / kFullCurrent; };
  subject.turn_by_hand = [driver](double level) {
    driver->emulator.TurnByHand(2, static_cast<int>(std::lround(1000 * level * kFullCurrent)));
  };
  return subject;
}

MonitorSubject PowerMeter(const PowerMeterEmulator::Settings& kind) {
  auto power = std::make_shared<std::atomic<double>>(0);
  auto plugged = std::make_shared<Plugged<PowerMeterEmulator>>(
      0x8078, std::function<double()>([power] { return power->load(); }), kind);
  auto monitor = ThorlabsMonitor::Open(plugged->Open(), MeterSettings());
  EXPECT_TRUE(monitor.ok()) << monitor.error().message;
  MonitorSubject subject;
  subject.monitor = std::move(monitor).value();
  subject.shine = [plugged, power](double relative) { *power = relative * kReference; };
  return subject;
}

MonitorSubject Pm100d() { return PowerMeter({}); }
MonitorSubject Pm400() {
  PowerMeterEmulator::Settings kind;
  kind.identity = "Thorlabs,PM400,P5000123,1.5.0";
  kind.says_when_ready = true;
  return PowerMeter(kind);
}

INSTANTIATE_TEST_SUITE_P(Dc2200, LightConformance, testing::Values(Dc2200));
INSTANTIATE_TEST_SUITE_P(Dc4100, LightConformance, testing::Values(Dc4100));
INSTANTIATE_TEST_SUITE_P(Pm100d, MonitorConformance, testing::Values(Pm100d));
INSTANTIATE_TEST_SUITE_P(Pm400, MonitorConformance, testing::Values(Pm400));

TEST(Dc2200Light, RefusesACurrentBeyondTheLimitOfItsDriver) {
  Plugged<Dc2200Emulator> plugged(0x80c8, 0.5);
  const auto light = Dc2200Light::Open(plugged.Open(), LightSettings());
  ASSERT_FALSE(light.ok());
  EXPECT_EQ(light.error().code, ErrorCode::kRefused);
  EXPECT_THAT(light.error().message, HasSubstr("light: "));
  EXPECT_THAT(light.error().message, HasSubstr("0.7 A"));
  EXPECT_THAT(light.error().message, HasSubstr("0.5 A"));
  EXPECT_EQ(plugged.emulator.Current(), 0);
}

// Example failure is a session in the dark that believes in its set-point.
TEST(Dc2200Light, NoticesThatThereIsNoLed) {
  Plugged<Dc2200Emulator> plugged(0x80c8);
  auto light = Dc2200Light::Open(plugged.Open(), LightSettings());
  ASSERT_TRUE(light.ok());
  ASSERT_TRUE((*light)->SetLevel(0.5).ok());
  plugged.emulator.RemoveLed();
  EXPECT_EQ(*(*light)->Level(), 0);
}

TEST(ThorlabsMonitor, RefusesAnotherInstrumentAndSettingsItCannotHave) {
  Plugged<Dc2200Emulator> light(0x8078);
  EXPECT_FALSE(ThorlabsMonitor::Open(light.Open(), MeterSettings()).ok());
}

TEST(ThorlabsMonitor, WritesItsSettingsWhateverWasLeftBehind) {
  Plugged<PowerMeterEmulator> plugged(0x8078, std::function<double()>([] { return 1e-3; }));
  ThorlabsMonitorSettings settings = MeterSettings();
  settings.range = 2e-3;
  const auto monitor = ThorlabsMonitor::Open(plugged.Open(), settings);
  ASSERT_TRUE(monitor.ok()) << monitor.error().message;
  EXPECT_EQ(plugged.emulator.wavelength_nm(), 550);
  EXPECT_EQ(plugged.emulator.averaging(), 10);
  EXPECT_FALSE(plugged.emulator.automatic());
  EXPECT_THAT((*monitor)->identity(), HasSubstr("550 nm, 10 averaged"));
  EXPECT_THAT((*monitor)->identity(), HasSubstr("S120C"));
}

TEST(ThorlabsMonitor, RefusesASettingThatReadsBackOtherwise) {
  Plugged<PowerMeterEmulator> plugged(0x8078, std::function<double()>([] { return 1e-3; }));
  plugged.emulator.set_rounds_wavelength_to(20);
  const auto monitor = ThorlabsMonitor::Open(plugged.Open(), MeterSettings());
  ASSERT_FALSE(monitor.ok());
  EXPECT_THAT(monitor.error().message, HasSubstr("SENS:CORR:WAV was set to 550 and reads"));
}

// Example failure is an f_r divided by 9.9e37.
TEST(ThorlabsMonitor, NoReadingIsAnError) {
  Plugged<PowerMeterEmulator> plugged(0x8078, std::function<double()>([] { return 1e-3; }));
  const auto monitor = ThorlabsMonitor::Open(plugged.Open(), MeterSettings());
  ASSERT_TRUE(monitor.ok());
  plugged.emulator.ReadNext("9.9E37");
  EXPECT_THAT((*monitor)->Read().error().message, HasSubstr("no reading"));
  plugged.emulator.ReadNext("soon");
  EXPECT_EQ((*monitor)->Read().error().code, ErrorCode::kProtocol);
  EXPECT_TRUE((*monitor)->Read().ok());
}

// What everybody gets wrong: after one time-out all later readings time out, too.
TEST(ThorlabsMonitor, ReadsAgainAfterATimeout) {
  Plugged<PowerMeterEmulator> plugged(0x8078, std::function<double()>([] { return 1e-3; }));
  ThorlabsMonitorSettings settings = MeterSettings();
  settings.reply_limit = settings.reading_limit = kShortLimit;
  const auto monitor = ThorlabsMonitor::Open(plugged.Open(), settings);
  ASSERT_TRUE(monitor.ok());
  plugged.device.Inject(UsbtmcFault::kSilent, 3);
  EXPECT_EQ((*monitor)->Read().error().code, ErrorCode::kTimeout);
  plugged.device.Inject(UsbtmcFault::kSilent, 0);
  const auto reading = (*monitor)->Read();
  ASSERT_TRUE(reading.ok()) << reading.error().message;
  EXPECT_NEAR(*reading, 1, 1e-3);
}

TEST(ThorlabsMonitor, ACableThatIsOutIsDisconnected) {
  Plugged<PowerMeterEmulator> plugged(0x8078, std::function<double()>([] { return 1e-3; }));
  const auto monitor = ThorlabsMonitor::Open(plugged.Open(), MeterSettings());
  ASSERT_TRUE(monitor.ok());
  plugged.bench.Unplug(&plugged.device);
  EXPECT_EQ((*monitor)->Read().error().code, ErrorCode::kDisconnected);
  EXPECT_EQ((*monitor)->Read().error().code, ErrorCode::kDisconnected);
}

}  // namespace
}  // namespace gonio
