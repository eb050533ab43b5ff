// SPDX-License-Identifier: Apache-2.0
// The LEDs on Thorlabs' drivers DC4100 and DC4104, at constant current: one of the four, or three
// of them as red, green and blue.

#pragma once

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "drivers/byte_link.h"
#include "drivers/light.h"
#include "drivers/line_reader.h"

namespace gonio {

struct Dc4100Led {
  int channel = 0;          // as the driver counts them, 0 .. 3
  double full_current = 0;  // A at level 1; > 0 and at most the driver's limits
};

struct Dc4100Settings {
  std::string name;  // in every error message
  // One; or three on channels that differ, in the order of LightColour: a light with colours.
  std::vector<Dc4100Led> leds;
  Seconds reply_limit{1};
};

// Level is current over full current, in steps of a milliampere; see Dc2200Light for what that
// means. The driver does not measure: Level() is its set-point, or 0 while the channel is off.
//
// One thread; the serial port (115200 baud as a rule) is the light's own. Errors as in axis.h.
class Dc4100Light final : public Light {
 public:
  // Off, at constant current. A single LED leaves the other channels as they are; of a light with
  // colours all channels are switched off, since a white LED that somebody left on is no colour.
  // kRefused: a full current beyond the limits of the driver (l?) or of the LED (ml?).
  static Result<std::unique_ptr<Light>> Open(std::unique_ptr<ByteLink> link,
                                             const Dc4100Settings& settings);
  ~Dc4100Light() override;

  const std::string& name() const override { return settings_.name; }
  const std::string& identity() const override { return identity_; }
  Result<void> SetLevel(double level) override;
  Result<double> Level() override;
  bool has_colours() const override { return settings_.leds.size() > 1; }
  // Switches the others off before this one is switched on, and reads all of them back.
  Result<void> Select(LightColour colour, std::stop_token stop) override;
  Result<std::optional<LightColour>> Selected() override;

 private:
  Dc4100Light(std::unique_ptr<ByteLink> link, const Dc4100Settings& settings)
      : link_(std::move(link)), lines_(link_.get()), settings_(settings) {}

  const Dc4100Led& lit() const { return settings_.leds[selected_]; }

  Result<void> Prepare();
  Result<void> SwitchOff();
  // Its part of the identity.
  Result<std::string> PrepareLed(const Dc4100Led& led);
  Result<void> Drive(double level);
  Result<double> LitLevel();
  Result<void> Change(std::size_t led);
  Result<std::optional<LightColour>> Lit();
  Result<std::string> Ask(const std::string& question);
  // Of one channel: "cc? 0".
  Result<double> Number(const std::string& question, int channel);
  // Asks whether the command was obeyed (e?).
  Result<void> Set(const std::string& command);
  // Sets and reads back.
  Result<void> SetTo(const std::string& setting, int channel, int value);
  Result<std::string> Exchange(const std::string& question);
  Error Named(const Error& error) const;

  const std::unique_ptr<ByteLink> link_;
  LineReader lines_;
  const Dc4100Settings settings_;
  std::string identity_;
  std::size_t selected_ = 0;  // index into the LEDs
};

}  // namespace gonio
