// SPDX-License-Identifier: Apache-2.0
// A light that drifts and a monitor that is noisy.

#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include "core/clock.h"
#include "drivers/light.h"
#include "sim/random.h"

namespace gonio {

// 1 at time zero, from where it goes with the given relative slope: a sine of eight hours, so that
// it stays bounded through the longest session (1.3 times the slope from 1 at most).
double SlowDrift(double per_hour, Seconds time);

// The lamp itself, which outlives the SimLight that dims it.
class SimLamp {
 public:
  // What goes wrong beside drift.
  struct Faults {
    double flicker = 0;      // relative standard deviation; a new value every millisecond
    std::uint64_t seed = 0;  // of the flicker
    Seconds fails_at{0};     // dark from then on, whatever the level; 0: never
  };

  // `drift_per_hour`: relative slope of the power at time zero (SlowDrift).
  explicit SimLamp(double drift_per_hour) : SimLamp(drift_per_hour, Faults{}) {}
  SimLamp(double drift_per_hour, const Faults& faults)
      : drift_per_hour_(drift_per_hour), faults_(faults) {}

  void set_level(double level) { level_ = level; }
  double level() const { return level_; }
  // Truth: relative to full power at time zero.
  double PowerAt(Seconds time) const;

 private:
  double drift_per_hour_;
  Faults faults_;
  double level_ = 0;
};

class SimLight final : public Light {
 public:
  SimLight(std::string name, std::shared_ptr<SimLamp> lamp);
  ~SimLight() override;
  const std::string& name() const override { return name_; }
  const std::string& identity() const override { return identity_; }
  Result<void> SetLevel(double level) override;
  Result<double> Level() override;

 private:
  const std::string name_;
  const std::string identity_ = "simulated";
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
