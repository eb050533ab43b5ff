// SPDX-License-Identifier: Apache-2.0
// An LED on Thorlabs' driver DC2200, at constant current.

#pragma once

#include <memory>
#include <string>
#include <utility>

#include "drivers/light.h"
#include "drivers/scpi.h"

namespace gonio {

struct Dc2200Settings {
  std::string name;         // in every error message
  double full_current = 0;  // A at level 1; > 0 and at most the limit set on the driver
  Seconds reply_limit = scpi::Instrument::kReplyLimit;
};

// Level is current over full current, which is light only roughly: LEDs droop and warm up. What was
// emitted the monitor says.
//
// SetLevel() reads the set-point and the state of the output back. Level() is the current that the
// driver measures through the LED, so an LED that is not there reads 0 whatever was set.
//
// One thread. Errors as in axis.h.
class Dc2200Light final : public Light {
 public:
  // Off, at constant current. kRefused: another instrument, or a full current beyond its limit.
  static Result<std::unique_ptr<Light>> Open(std::unique_ptr<MessageLink> link,
                                             const Dc2200Settings& settings);
  ~Dc2200Light() override;

  const std::string& name() const override { return settings_.name; }
  const std::string& identity() const override { return identity_; }
  Result<void> SetLevel(double level) override;
  Result<double> Level() override;

 private:
  Dc2200Light(std::unique_ptr<scpi::Instrument> driver, const Dc2200Settings& settings)
      : driver_(std::move(driver)), settings_(settings) {}

  Result<void> Prepare();
  Result<void> Switch(bool on);
  Result<void> SetCurrent(double current);
  Error Named(const Error& error) const;

  const std::unique_ptr<scpi::Instrument> driver_;
  const Dc2200Settings settings_;
  std::string identity_;
};

}  // namespace gonio
