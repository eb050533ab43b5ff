// SPDX-License-Identifier: Apache-2.0
// One of the four LEDs on Thorlabs' drivers DC4100 and DC4104, at constant current.

#pragma once

#include <memory>
#include <string>
#include <utility>

#include "drivers/byte_link.h"
#include "drivers/light.h"
#include "drivers/line_reader.h"

namespace gonio {

struct Dc4100Settings {
  std::string name;         // in every error message
  int channel = 0;          // of the LED, as the driver counts them
  double full_current = 0;  // A at level 1; > 0 and at most the driver's limits
  Seconds reply_limit{1};
};

// Level is current over full current, in steps of a milliampere; see Dc2200Light for what that
// means. The driver does not measure: Level() is its set-point, or 0 while the channel is off.
//
// One thread; the serial port (115200 baud as a rule) is the light's own. Errors as in axis.h.
class Dc4100Light final : public Light {
 public:
  // Off, at constant current; the other channels stay as they are. kRefused: a full current beyond
  // the limits of the driver (l?) or of the LED (ml?).
  static Result<std::unique_ptr<Light>> Open(std::unique_ptr<ByteLink> link,
                                             const Dc4100Settings& settings);
  ~Dc4100Light() override;

  const std::string& name() const override { return settings_.name; }
  const std::string& identity() const override { return identity_; }
  Result<void> SetLevel(double level) override;
  Result<double> Level() override;

 private:
  Dc4100Light(std::unique_ptr<ByteLink> link, const Dc4100Settings& settings)
      : link_(std::move(link)), lines_(link_.get()), settings_(settings) {}

  Result<void> Prepare();
  // Of our channel: "cc? 0".
  Result<std::string> Ask(const std::string& question);
  Result<std::string> AskChannel(const std::string& question);
  Result<double> Number(const std::string& question);
  // Asks whether the command was obeyed (e?).
  Result<void> Set(const std::string& command);
  // Sets and reads back.
  Result<void> SetTo(const std::string& setting, int value);
  Result<std::string> Exchange(const std::string& question);
  Error Named(const Error& error) const;

  const std::unique_ptr<ByteLink> link_;
  LineReader lines_;
  const Dc4100Settings settings_;
  std::string identity_;
};

}  // namespace gonio
