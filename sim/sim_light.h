// SPDX-License-Identifier: Apache-2.0
// A light that drifts and a monitor that is noisy.

#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "brdf/brdf.h"
#include "core/clock.h"
#include "drivers/light.h"
#include "sim/random.h"

namespace gonio {

// 1 at time zero, from where it goes with the given relative slope: a sine of eight hours, so that
// it stays bounded through the longest session (1.3 times the slope from 1 at most).
double SlowDrift(double per_hour, Seconds time);

// Light in the bands of red, green and blue, relative to white light of the same power: all three
// times as much in its own band. `crosstalk`: of a colour's light lies so much in each band beside
// its own. None: dark.
Rgb SpectrumOf(const std::optional<LightColour>& colour, double crosstalk);

// The lamp itself, which outlives the SimLight that dims it.
class SimLamp {
 public:
  // What goes wrong beside drift.
  struct Faults {
    double flicker = 0;      // relative standard deviation; a new value every millisecond
    std::uint64_t seed = 0;  // of the flicker
    Seconds fails_at{0};     // dark from then on, whatever the level; 0: never
  };

  // What colour there is at a time, by whatever stands before the lamp; empty: none gets through.
  using Filter = std::function<std::optional<LightColour>(Seconds)>;

  // `drift_per_hour`: relative slope of the power at time zero (SlowDrift).
  explicit SimLamp(double drift_per_hour) : SimLamp(drift_per_hour, Faults{}) {}
  SimLamp(double drift_per_hour, const Faults& faults)
      : drift_per_hour_(drift_per_hour), faults_(faults) {}

  void set_level(double level) { level_ = level; }
  double level() const { return level_; }
  // Makes a white lamp one of three LEDs, the first of them selected.
  void GiveColours(double crosstalk);
  // Puts a wheel before a white lamp.
  void SetFilter(Filter filter, double crosstalk);
  bool has_colours() const { return led_.has_value(); }
  void Select(LightColour colour) { led_ = colour; }
  // Truth: relative to full power at time zero.
  double PowerAt(Seconds time) const;
  // Truth: SpectrumOf() its colour; of a white lamp all 1.
  Rgb SpectrumAt(Seconds time) const;
  std::optional<LightColour> ColourAt(Seconds time) const;

 private:
  double drift_per_hour_;
  Faults faults_;
  double level_ = 0;
  std::optional<LightColour> led_;
  Filter filter_;
  double crosstalk_ = 0;
};

class SimLight final : public Light {
 public:
  SimLight(std::string name, std::shared_ptr<SimLamp> lamp);
  ~SimLight() override;
  const std::string& name() const override { return name_; }
  const std::string& identity() const override { return identity_; }
  Result<void> SetLevel(double level) override;
  Result<double> Level() override;
  bool has_colours() const override { return lamp_->has_colours(); }
  Result<void> Select(LightColour colour, std::stop_token stop) override;
  Result<std::optional<LightColour>> Selected() override;

 private:
  const std::string name_;
  const std::string identity_;
  const std::shared_ptr<SimLamp> lamp_;
};

class SimMonitor final : public Monitor {
 public:
  // `noise`: relative standard deviation of one reading.
  SimMonitor(std::string name, std::shared_ptr<const SimLamp> lamp, double noise,
             const Clock& clock, Random random);
  const std::string& name() const override { return name_; }
  const std::string& identity() const override { return identity_; }
  Result<double> Read() override;
  // Draws from `random` from now on.
  void Reseed(Random random) { random_ = random; }

 private:
  const std::string name_;
  const std::string identity_ = "simulated";
  const std::shared_ptr<const SimLamp> lamp_;
  const double noise_;
  const Clock& clock_;
  Random random_;
};

}  // namespace gonio
