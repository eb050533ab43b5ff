// SPDX-License-Identifier: Apache-2.0
#include "drivers/thorlabs_monitor.h"

#include <fmt/format.h>

#include <cmath>
#include <thread>
#include <utility>
#include <vector>

#include "core/check.h"
#include "drivers/deadline.h"
#include "drivers/wire_text.h"

namespace gonio {
namespace {

constexpr Seconds kPollInterval{0.002};
constexpr double kNoReading = 9.9e37;    // and beyond: how SCPI spells infinity and NaN
constexpr unsigned kMeasuresPower = 1;   // flags of a sensor
constexpr double kWavelengthStep = 0.5;  // nm, by which the meter may round

Error Refused(std::string message) { return {ErrorCode::kRefused, std::move(message)}; }

// `"S120C","16060232","2-JUN-2021",1,18,33` without quotes.
std::vector<std::string> FieldsOf(std::string_view answer) {
  std::vector<std::string> fields(1);
  bool quoted = false;
  for (const char c : answer) {
    if (c == '"') {
      quoted = !quoted;
    } else if (c == ',' && !quoted) {
      fields.emplace_back();
    } else {
      fields.back() += c;
    }
  }
  return fields;
}

// Only some meters have FETC:STAT?; the others would not answer it.
bool SaysWhenReady(const std::string& identity) {
  return identity.find("PM400") != std::string::npos ||
         identity.find("PM100D2") != std::string::npos;
}

}  // namespace

Result<std::unique_ptr<Monitor>> ThorlabsMonitor::Open(std::unique_ptr<MessageLink> link,
                                                       const ThorlabsMonitorSettings& settings) {
  auto meter = scpi::Instrument::Open(std::move(link), settings.reply_limit);
  if (!meter) return Error{meter.error().code, settings.name + ": " + meter.error().message};
  std::unique_ptr<ThorlabsMonitor> monitor(new ThorlabsMonitor(std::move(meter).value(), settings));
  if (const auto ready = monitor->Prepare(); !ready) return monitor->Named(ready.error());
  return std::unique_ptr<Monitor>(std::move(monitor));
}

Result<void> ThorlabsMonitor::Prepare() {
  GONIO_CHECK(!settings_.colours.empty(), "a wavelength and a power");
  for (const MonitoredLight& light : settings_.colours) {
    // Also true of NaN.
    if (!(light.reference > 0) || !std::isfinite(light.reference)) {
      return Refused(fmt::format("a reference power of {} W is not above 0", light.reference));
    }
  }
  const auto sensor = Sensor();
  if (!sensor) return sensor.error();
  if (const auto power = meter_->Command("CONF:POW"); !power) return power;
  if (const auto watt = meter_->Command("SENS:POW:UNIT W"); !watt) return watt;
  if (const auto known = CheckWavelengths(); !known) return known;
  const auto set = Set("SENS:CORR:WAV", settings_.colours.front().wavelength_nm, kWavelengthStep);
  if (!set) return set;
  if (const auto count = Set("SENS:AVER", settings_.averaging, 0); !count) return count;
  const auto range = SetRange();
  if (!range) return range.error();
  says_when_ready_ = SaysWhenReady(meter_->identity());
  std::string wavelengths, powers;
  for (const MonitoredLight& light : settings_.colours) {
    const char* const slash = wavelengths.empty() ? "" : " / ";
    wavelengths += fmt::format("{}{:.6g}", slash, light.wavelength_nm);
    powers += fmt::format("{}{:.6g}", slash, light.reference);
  }
  identity_ = fmt::format("{}, sensor {}, {} nm, {} averaged, {}, 1 is {} W", meter_->identity(),
                          *sensor, wavelengths, settings_.averaging, *range, powers);
  return {};
}

// Name, serial number and date of calibration.
Result<std::string> ThorlabsMonitor::Sensor() {
  const auto answer = meter_->Query("SYST:SENS:IDN?");
  if (!answer) return answer.error();
  const std::vector<std::string> fields = FieldsOf(*answer);
  const auto flags = fields.size() == 6 ? NumberIn(fields[5], "flags of the sensor")
                                        : Error{ErrorCode::kProtocol, ""};
  if (!flags || *flags < 0 || *flags > 0xffff) {
    return Error{ErrorCode::kProtocol,
                 fmt::format("{}: {} describes no sensor", meter_->name(), Quoted(*answer))};
  }
  if ((static_cast<unsigned>(*flags) & kMeasuresPower) == 0) {
    return Refused(
        fmt::format("{}: no sensor for power is connected: {}", meter_->name(), Quoted(*answer)));
  }
  return fmt::format("{} {} calibrated {}", fields[0], fields[1], fields[2]);
}

Result<void> ThorlabsMonitor::CheckWavelengths() {
  const auto least = meter_->Number("SENS:CORR:WAV? MIN");
  if (!least) return least.error();
  const auto most = meter_->Number("SENS:CORR:WAV? MAX");
  if (!most) return most.error();
  for (const MonitoredLight& light : settings_.colours) {
    // Also true of NaN.
    if (!(light.wavelength_nm >= *least && light.wavelength_nm <= *most)) {
      return Refused(fmt::format("{:.6g} nm is outside {:.6g} .. {:.6g} nm, the sensor's own",
                                 light.wavelength_nm, *least, *most));
    }
  }
  return {};
}

Result<void> ThorlabsMonitor::Expect(LightColour colour) {
  const auto index = static_cast<std::size_t>(colour);
  if (settings_.colours.size() == 1 || index == expected_) return {};
  const auto set = Set("SENS:CORR:WAV", settings_.colours.at(index).wavelength_nm, kWavelengthStep);
  if (!set) return Named(set.error());
  expected_ = index;
  return {};
}

// In words.
Result<std::string> ThorlabsMonitor::SetRange() {
  const bool automatic = settings_.range == 0;
  if (const auto set = Set("SENS:POW:RANG:AUTO", automatic ? 1 : 0, 0); !set) return set.error();
  if (automatic) return std::string("range automatic");
  const auto set = meter_->Command(fmt::format("SENS:POW:RANG {:.6e}", settings_.range));
  if (!set) return set.error();
  const auto got = meter_->Number("SENS:POW:RANG?");
  if (!got) return got.error();
  // The meter takes the next of its ranges in which this fits.
  if (*got < settings_.range * (1 - 1e-3)) {
    return Refused(
        fmt::format("the range was to hold {:.6g} W and is {:.6g} W", settings_.range, *got));
  }
  return fmt::format("range {:.6g} W", *got);
}

Result<void> ThorlabsMonitor::Set(const std::string& setting, double value, double tolerance) {
  const auto set = meter_->Command(fmt::format("{} {}", setting, value));
  if (!set) return set;
  const auto got = meter_->Number(setting + "?");
  if (!got) return got.error();
  if (std::abs(*got - value) <= tolerance) return {};
  return Refused(fmt::format("{}: {} was set to {:.6g} and reads {:.6g}", meter_->name(), setting,
                             value, *got));
}

Result<double> ThorlabsMonitor::Read() {
  const auto power = Power();
  if (!power) return Named(power.error());
  return *power / settings_.colours[expected_].reference;
}

Result<double> ThorlabsMonitor::Power() {
  // Without it FETC? repeats the reading before.
  if (const auto started = meter_->Command("INIT"); !started) return started.error();
  if (const auto ready = AwaitReading(); !ready) return ready.error();
  const auto power = meter_->Number("FETC?", settings_.reading_limit);
  if (!power) return power.error();
  if (std::abs(*power) >= kNoReading) {
    return Refused(fmt::format(
        "{}: no reading: {}", meter_->name(),
        settings_.range > 0 ? "the power is beyond the range" : "the power is beyond the sensor"));
  }
  return power;
}

Result<void> ThorlabsMonitor::AwaitReading() {
  if (!says_when_ready_) return {};
  const Deadline deadline(settings_.reading_limit);
  while (true) {
    const auto ready = meter_->Number("FETC:STAT?");
    if (!ready) return ready.error();
    if (*ready != 0) return {};
    if (deadline.Left() <= Seconds(0)) {
      return Error{ErrorCode::kTimeout, fmt::format("{}: no reading within {:.3g} s",
                                                    meter_->name(), deadline.limit().count())};
    }
    std::this_thread::sleep_for(kPollInterval);
  }
}

Error ThorlabsMonitor::Named(const Error& error) const {
  return {error.code, fmt::format("{}: {}", name(), error.message)};
}

}  // namespace gonio
