// SPDX-License-Identifier: Apache-2.0
// One of Thorlabs' power meters as the monitor: PM100D, PM100A, PM100USB, PM160, PM400, ...

#pragma once

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "drivers/light.h"
#include "drivers/scpi.h"

namespace gonio {

struct MonitoredLight {
  double wavelength_nm = 0;  // that the meter converts its current to power for; > 0
  double reference = 0;      // W, > 0: the power at calibration, which reads 1
};

struct ThorlabsMonitorSettings {
  std::string name;  // in every error message
  // One for whatever light there is; or three, by LightColour.
  std::vector<MonitoredLight> colours;
  int averaging = 1;  // readings of the meter that make one of ours; > 0
  double range = 0;   // W, the least that must fit; 0: the meter chooses
  Seconds reply_limit = scpi::Instrument::kReplyLimit;
  // For a reading. The meter gives up by itself after ten seconds and must not be spoken to before.
  Seconds reading_limit{12};
};

// Settings outlive the meter being switched off, so each is written and read back. A reading is
// started and fetched (INIT, FETC?): asking for both at once (READ?) can block the meter for good.
//
// One thread. Errors as in axis.h.
class ThorlabsMonitor final : public Monitor {
 public:
  // kRefused: no power sensor connected, or settings that the meter or its sensor cannot have.
  static Result<std::unique_ptr<Monitor>> Open(std::unique_ptr<MessageLink> link,
                                               const ThorlabsMonitorSettings& settings);

  const std::string& name() const override { return settings_.name; }
  const std::string& identity() const override { return identity_; }
  Result<double> Read() override;
  // Sets the wavelength, where each colour has its own.
  Result<void> Expect(LightColour colour) override;

 private:
  ThorlabsMonitor(std::unique_ptr<scpi::Instrument> meter, const ThorlabsMonitorSettings& settings)
      : meter_(std::move(meter)), settings_(settings) {}

  Result<void> Prepare();
  Result<std::string> Sensor();
  Result<void> CheckWavelengths();
  Result<std::string> SetRange();
  Result<void> AwaitReading();
  Result<double> Power();
  // Writes and reads back.
  Result<void> Set(const std::string& setting, double value, double tolerance);
  Error Named(const Error& error) const;

  const std::unique_ptr<scpi::Instrument> meter_;
  const ThorlabsMonitorSettings settings_;
  std::string identity_;
  std::size_t expected_ = 0;  // index into the colours
  bool says_when_ready_ = false;
};

}  // namespace gonio
