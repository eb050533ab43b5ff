// SPDX-License-Identifier: Apache-2.0
// A light behind a filter wheel: any light, and any rotary axis.

#pragma once

#include <array>
#include <memory>
#include <string>

#include "drivers/axis.h"
#include "drivers/light.h"

namespace gonio {

struct FilterWheelSettings {
  std::array<double, 3> positions{};  // rad, by LightColour; within the wheel's limits
  int retries = 2;                    // of a turn that ended outside the wheel's tolerance
};

// The wheel may as well stand before the camera. It turns while the light is on: whoever exposes
// waits for Select(), which homes a wheel that is not homed.
//
// One thread. Errors are those of the light and the axis; kRefused, too, where the wheel missed its
// place as often as it was sent there.
class FilterWheelLight final : public Light {
 public:
  // `light` has no colours of its own.
  FilterWheelLight(std::unique_ptr<Light> light, std::unique_ptr<Axis> wheel,
                   const FilterWheelSettings& settings);

  const std::string& name() const override { return light_->name(); }
  const std::string& identity() const override { return identity_; }
  Result<void> SetLevel(double level) override { return light_->SetLevel(level); }
  Result<double> Level() override { return light_->Level(); }
  bool has_colours() const override { return true; }
  Result<void> Select(LightColour colour, std::stop_token stop) override;
  // The wheel stands at the filter, and the light is on.
  Result<std::optional<LightColour>> Selected() override;

 private:
  bool IsAt(double position, LightColour colour) const;
  Result<void> Turn(double from, double to, std::stop_token stop);
  Result<void> Leg(double to, std::stop_token stop);

  const std::unique_ptr<Light> light_;
  const std::unique_ptr<Axis> wheel_;
  const FilterWheelSettings settings_;
  const std::string identity_;
};

}  // namespace gonio
