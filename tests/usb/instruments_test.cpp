// SPDX-License-Identifier: Apache-2.0
// Thorlabs' LED driver DC2200 and power meters, over the real libusb.
#include <gmock/gmock.h>

#include <optional>

#include "drivers/dc2200_light.h"
#include "drivers/thorlabs_monitor.h"
#include "sim/scpi_instruments.h"
#include "tests/conformance/light.h"
#include "tests/conformance/monitor.h"
#include "tests/usb/usb_instrument.h"

namespace gonio {
namespace {

using testing::HasSubstr;

constexpr double kFull = 0.7;            // A
constexpr double kWattPerAmpere = 1e-3;  // of the lamp, on the sensor
constexpr double kReference = kFull * kWattPerAmpere;

// A lamp and a power meter that sees it. Members are destroyed last to first.
struct Bench {
  Dc2200Emulator lamp;
  std::optional<double> daylight;  // W on the sensor instead of the lamp's
  PowerMeterEmulator meter;
  UsbtmcEmulator lamp_cable{PlateOf(0x80c8, "M00310001"),
                            [this](std::string_view line) { return lamp.Receive(line); }};
  UsbtmcEmulator meter_cable{PlateOf(0x8078, "P0012345"),
                             [this](std::string_view line) { return meter.Receive(line); }};
  UsbBench usb;

  explicit Bench(PowerMeterEmulator::Settings settings = {})
      : meter([this] { return daylight.value_or(lamp.Current() * kWattPerAmpere); },
              std::move(settings)) {
    usb.Plug(&lamp_cable);
    usb.Plug(&meter_cable);
  }

  static Dc2200Settings LightSettings() {
    return {.name = "lamp", .full_current = kFull, .reply_limit = kShortLimit};
  }
  Result<std::unique_ptr<Light>> OpenLight(const Dc2200Settings& settings = LightSettings()) {
    return Dc2200Light::Open(OpenedDevice(lamp_cable.plate()), settings);
  }
  static ThorlabsMonitorSettings MonitorSettings() {
    return {.name = "monitor",
            .colours = {{.wavelength_nm = 550, .reference = kReference}},
            .averaging = 100,
            .range = 0,
            .reply_limit = kShortLimit,
            .reading_limit = kShortLimit};
  }
  Result<std::unique_ptr<Monitor>> OpenMonitor(
      const ThorlabsMonitorSettings& settings = MonitorSettings()) {
    return ThorlabsMonitor::Open(OpenedDevice(meter_cable.plate()), settings);
  }
};

LightSubject Dc2200() {
  auto bench = std::make_shared<Bench>();
  auto light = bench->OpenLight();
  EXPECT_TRUE(light.ok()) << light.error().message;
  LightSubject subject;
  subject.emitted = [bench] { return bench->lamp.Current() / kFull; };
  subject.turn_by_hand = [bench](double level) { bench->lamp.TurnByHand(level * kFull); };
  subject.light = std::move(light).value();
  return subject;
}
INSTANTIATE_TEST_SUITE_P(Dc2200, LightConformance, testing::Values(Dc2200));

MonitorFactory Meter(const PowerMeterEmulator::Settings& settings) {
  return [settings] {
    auto bench = std::make_shared<Bench>(settings);
    ThorlabsMonitorSettings wanted = Bench::MonitorSettings();
    wanted.range = 4e-3;
    auto monitor = bench->OpenMonitor(wanted);
    EXPECT_TRUE(monitor.ok()) << monitor.error().message;
    MonitorSubject subject;
    subject.shine = [bench](double power) { bench->daylight = power * kReference; };
    subject.dazzles = 6e-3 / kReference;  // beyond the range of 5 mW
    subject.monitor = std::move(monitor).value();
    return subject;
  };
}
INSTANTIATE_TEST_SUITE_P(Pm100d, MonitorConformance, testing::Values(Meter({})));
INSTANTIATE_TEST_SUITE_P(Pm400, MonitorConformance,
                         testing::Values(Meter({.identity = "THORLABS,PM400,P5000001,1.0.0",
                                                .sensor = "\"S120C\",\"1\",\"2-JUN-2021\",1,18,33",
                                                .says_when_ready = true})));

TEST(Instruments, TheMonitorSeesTheLamp) {
  Bench bench;
  const auto light = bench.OpenLight();
  const auto monitor = bench.OpenMonitor();
  ASSERT_TRUE(light.ok() && monitor.ok());
  for (const double level : {1.0, 0.3, 0.0}) {
    ASSERT_TRUE((*light)->SetLevel(level).ok());
    EXPECT_NEAR(*(*monitor)->Read(), level, 1e-5);
    EXPECT_NEAR(*(*light)->Level(), level, 1e-5);
  }
}

// The lamp.

TEST(Dc2200Light, IsOffOnceOpenedAndSaysWhatItIs) {
  Bench bench;
  bench.lamp.TurnByHand(0.2);
  const auto light = bench.OpenLight();
  ASSERT_TRUE(light.ok()) << light.error().message;
  EXPECT_EQ(bench.lamp.Current(), 0);
  EXPECT_EQ((*light)->identity(),
            "Thorlabs,DC2200,M00310001,1.5.0, constant current, full 0.7 A, limit 1 A");
}

TEST(Dc2200Light, RefusesMoreThanTheLimitOfTheDriver) {
  Bench bench;
  for (const double full : {1.01, 0.0, -1.0, std::nan("")}) {
    Dc2200Settings settings = Bench::LightSettings();
    settings.full_current = full;
    const auto light = bench.OpenLight(settings);
    ASSERT_FALSE(light.ok());
    EXPECT_EQ(light.error().code, ErrorCode::kRefused);
    EXPECT_THAT(light.error().message,
                HasSubstr("A is outside 0 .. 1 A, the limit set on the driver"));
    EXPECT_EQ(bench.lamp.Current(), 0);
  }
}

TEST(Dc2200Light, RefusesAnotherInstrument) {
  Bench bench;
  const auto light =
      Dc2200Light::Open(OpenedDevice(bench.meter_cable.plate()), Bench::LightSettings());
  ASSERT_FALSE(light.ok());
  EXPECT_EQ(light.error().message,
            "lamp: USB 1313:8078 P0012345 is no DC2200 but Thorlabs,PM100D,P0012345,2.4.0");
}

// Example failure is a session in the dark.
TEST(Dc2200Light, NoticesThatTheLedIsNotThere) {
  Bench bench;
  const auto light = bench.OpenLight();
  ASSERT_TRUE(light.ok());
  ASSERT_TRUE((*light)->SetLevel(0.5).ok());
  bench.lamp.RemoveLed();
  EXPECT_EQ(*(*light)->Level(), 0);
  const auto set = (*light)->SetLevel(0.5);
  ASSERT_FALSE(set.ok());
  EXPECT_EQ(set.error().code, ErrorCode::kRefused);
  EXPECT_EQ(set.error().message,
            "lamp: the output was switched on and reads 0; is an LED connected?");
}

// The meter.

TEST(ThorlabsMonitor, WritesAllItsSettingsAndSaysThem) {
  Bench bench;
  const auto monitor = bench.OpenMonitor();
  ASSERT_TRUE(monitor.ok()) << monitor.error().message;
  EXPECT_EQ(bench.meter.wavelength_nm(), 550);
  EXPECT_EQ(bench.meter.averaging(), 100);
  EXPECT_TRUE(bench.meter.automatic());
  EXPECT_EQ((*monitor)->identity(),
            "Thorlabs,PM100D,P0012345,2.4.0, sensor S120C 16060232 calibrated 2-JUN-2021, 550 nm, "
            "100 averaged, range automatic, 1 is 0.0007 W");
}

TEST(ThorlabsMonitor, TakesTheRangeThatHoldsThePower) {
  Bench bench;
  ThorlabsMonitorSettings settings = Bench::MonitorSettings();
  settings.range = 8e-4;
  const auto monitor = bench.OpenMonitor(settings);
  ASSERT_TRUE(monitor.ok()) << monitor.error().message;
  EXPECT_FALSE(bench.meter.automatic());
  EXPECT_EQ(bench.meter.range(), 5e-3);
  EXPECT_THAT((*monitor)->identity(), HasSubstr("range 0.005 W"));
}

std::string WhyNot(Bench& bench, const ThorlabsMonitorSettings& settings) {
  const auto monitor = bench.OpenMonitor(settings);
  if (monitor.ok()) return "opened";
  EXPECT_EQ(monitor.error().code, ErrorCode::kRefused);
  return monitor.error().message;
}

TEST(ThorlabsMonitor, RefusesSettingsThatItCannotHave) {
  Bench bench;
  ThorlabsMonitorSettings settings = Bench::MonitorSettings();
  settings.colours[0].wavelength_nm = 1550;
  EXPECT_EQ(WhyNot(bench, settings),
            "monitor: 1550 nm is outside 400 .. 1100 nm, the sensor's own");
  settings = Bench::MonitorSettings();
  settings.range = 1;
  EXPECT_EQ(WhyNot(bench, settings), "monitor: the range was to hold 1 W and is 0.05 W");
  settings = Bench::MonitorSettings();
  settings.averaging = 0;
  EXPECT_THAT(WhyNot(bench, settings), HasSubstr("refused \"SENS:AVER 0\": -222"));
  settings = Bench::MonitorSettings();
  settings.colours[0].reference = 0;
  EXPECT_THAT(WhyNot(bench, settings), HasSubstr("a reference power of 0 W is not above 0"));
}

// Example failure is a meter that keeps another wavelength and is believed.
TEST(ThorlabsMonitor, NoticesASettingThatWasNotTaken) {
  Bench bench;
  bench.meter.set_rounds_wavelength_to(100);
  EXPECT_EQ(WhyNot(bench, Bench::MonitorSettings()),
            "monitor: USB 1313:8078 P0012345: SENS:CORR:WAV was set to 550 and reads 600");
}

// Example failure is blue that is read with the photodiode's response to red.
TEST(ThorlabsMonitor, ReadsEachColourAtItsWavelengthAndRelativeToItsPower) {
  Bench bench;
  ThorlabsMonitorSettings settings = Bench::MonitorSettings();
  settings.colours = {{.wavelength_nm = 625, .reference = 1e-3},
                      {.wavelength_nm = 530, .reference = 2e-3},
                      {.wavelength_nm = 470, .reference = 4e-3}};
  const auto monitor = bench.OpenMonitor(settings);
  ASSERT_TRUE(monitor.ok()) << monitor.error().message;
  EXPECT_THAT((*monitor)->identity(), HasSubstr("625 / 530 / 470 nm"));
  EXPECT_THAT((*monitor)->identity(), HasSubstr("1 is 0.001 / 0.002 / 0.004 W"));
  bench.daylight = 1e-3;
  const std::array<double, 3> read = {1, 0.5, 0.25};
  for (const LightColour colour : {LightColour::kBlue, LightColour::kRed, LightColour::kGreen}) {
    const auto i = static_cast<std::size_t>(colour);
    ASSERT_TRUE((*monitor)->Expect(colour).ok());
    EXPECT_EQ(bench.meter.wavelength_nm(), settings.colours[i].wavelength_nm);
    EXPECT_NEAR(*(*monitor)->Read(), read[i], 1e-6);
  }
}

TEST(ThorlabsMonitor, RefusesAWavelengthOfAnyColourThatItsSensorDoesNotHave) {
  Bench bench;
  ThorlabsMonitorSettings settings = Bench::MonitorSettings();
  settings.colours.resize(3, settings.colours[0]);
  settings.colours[2].wavelength_nm = 300;
  EXPECT_EQ(WhyNot(bench, settings), "monitor: 300 nm is outside 400 .. 1100 nm, the sensor's own");
}

TEST(ThorlabsMonitor, RefusesAMeterWithoutSensor) {
  Bench none({.identity = "Thorlabs,PM100D,P0012345,2.4.0",
              .sensor = "\"no sensor\",\"\",\"\",0,0,0",
              .says_when_ready = false});
  EXPECT_THAT(WhyNot(none, Bench::MonitorSettings()),
              HasSubstr("no sensor for power is connected"));
}

TEST(ThorlabsMonitor, ReadsNoNumberWhereThereIsNone) {
  Bench bench;
  const auto monitor = bench.OpenMonitor();
  ASSERT_TRUE(monitor.ok());
  for (const char* none : {"9.91E+37", "9.9E37", "-9.9E+37"}) {
    bench.meter.ReadNext(none);
    const auto reading = (*monitor)->Read();
    ASSERT_FALSE(reading.ok()) << none;
    EXPECT_EQ(reading.error().code, ErrorCode::kRefused) << none;
  }
  for (const char* none : {"NAN", "inf", "1e999", "7.5E-4W"}) {
    bench.meter.ReadNext(none);
    const auto reading = (*monitor)->Read();
    ASSERT_FALSE(reading.ok()) << none;
    EXPECT_EQ(reading.error().code, ErrorCode::kProtocol) << none;
  }
  EXPECT_TRUE((*monitor)->Read().ok());
}

// What goes wrong on the cable.

TEST(Instruments, ALateAnswerIsNotTakenForAnothers) {
  Bench bench;
  const auto light = bench.OpenLight();
  ASSERT_TRUE(light.ok());
  ASSERT_TRUE((*light)->SetLevel(0.5).ok());
  bench.lamp_cable.Inject(UsbtmcFault::kLate);
  EXPECT_NEAR(*(*light)->Level(), 0.5, 1e-5);  // asked twice
  for (int i = 0; i < 3; ++i) {
    bench.lamp_cable.Inject(UsbtmcFault::kLate);
    ASSERT_FALSE((*light)->SetLevel(0.25).ok() && bench.lamp.Current() != 0.25 * kFull);
    bench.lamp_cable.Inject(UsbtmcFault::kLate, 0);
    ASSERT_TRUE((*light)->SetLevel(0.75).ok());
    EXPECT_NEAR(*(*light)->Level(), 0.75, 1e-5);
  }
}

class InstrumentFaults : public testing::TestWithParam<UsbtmcFault> {};

// Whatever went wrong, a reading is right or is none, and the next is right.
TEST_P(InstrumentFaults, NeverMakeAReadingWrong) {
  Bench bench;
  const auto monitor = bench.OpenMonitor();
  ASSERT_TRUE(monitor.ok());
  bench.daylight = 0.4 * kReference;
  for (int times = 1; times <= 3; ++times) {
    bench.meter_cable.Inject(GetParam(), times);
    const auto reading = (*monitor)->Read();
    if (reading) {
      EXPECT_NEAR(*reading, 0.4, 1e-6);
    }
    bench.meter_cable.Inject(GetParam(), 0);
    const auto next = (*monitor)->Read();
    ASSERT_TRUE(next.ok()) << next.error().message;
    EXPECT_NEAR(*next, 0.4, 1e-6);
  }
}
INSTANTIATE_TEST_SUITE_P(All, InstrumentFaults,
                         testing::Values(UsbtmcFault::kSilent, UsbtmcFault::kLate,
                                         UsbtmcFault::kStallOut, UsbtmcFault::kStallIn,
                                         UsbtmcFault::kWrongTag, UsbtmcFault::kNoEnd,
                                         UsbtmcFault::kOversize, UsbtmcFault::kShort,
                                         UsbtmcFault::kEmptyFirst, UsbtmcFault::kHeaderFirst));

TEST(Instruments, StayDisconnected) {
  Bench bench;
  auto light = bench.OpenLight();
  auto monitor = bench.OpenMonitor();
  ASSERT_TRUE(light.ok() && monitor.ok());
  bench.usb.Unplug(&bench.lamp_cable);
  bench.usb.Unplug(&bench.meter_cable);
  for (int i = 0; i < 2; ++i) {
    EXPECT_EQ((*light)->SetLevel(0.5).error().code, ErrorCode::kDisconnected);
    EXPECT_EQ((*light)->Level().error().code, ErrorCode::kDisconnected);
    EXPECT_EQ((*monitor)->Read().error().code, ErrorCode::kDisconnected);
  }
  light = Error{ErrorCode::kDisconnected, ""};
  bench.usb.Plug(&bench.lamp_cable);
  light = bench.OpenLight();
  ASSERT_TRUE(light.ok()) << light.error().message;
  EXPECT_TRUE((*light)->SetLevel(0.5).ok());
}

}  // namespace
}  // namespace gonio
