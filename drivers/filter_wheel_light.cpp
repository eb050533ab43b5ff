// SPDX-License-Identifier: Apache-2.0
#include "drivers/filter_wheel_light.h"

#include <fmt/format.h>

#include <cmath>
#include <utility>

#include "core/check.h"
#include "core/units.h"
#include "drivers/move_time.h"

namespace gonio {
namespace {

double PositionOf(const FilterWheelSettings& settings, LightColour colour) {
  return settings.positions[static_cast<std::size_t>(colour)];
}

std::string IdentityOf(const Light& light, const Axis& wheel, const FilterWheelSettings& settings) {
  std::string places;
  for (const LightColour colour : kLightColours) {
    places += fmt::format("{}{} at {:.6g}", places.empty() ? "" : ", ", ToString(colour),
                          DegFromRad(PositionOf(settings, colour)));
  }
  return fmt::format("{}; filters {} deg of {}", light.identity(), places, wheel.identity());
}

}  // namespace

FilterWheelLight::FilterWheelLight(std::unique_ptr<Light> light, std::unique_ptr<Axis> wheel,
                                   const FilterWheelSettings& settings)
    : light_(std::move(light)),
      wheel_(std::move(wheel)),
      settings_(settings),
      identity_(IdentityOf(*light_, *wheel_, settings)) {
  GONIO_CHECK(!light_->has_colours(), "a filter before a light that is coloured already");
}

bool FilterWheelLight::IsAt(double position, LightColour colour) const {
  return std::abs(position - PositionOf(settings_, colour)) <= wheel_->limits().position_tolerance;
}

Result<void> FilterWheelLight::Leg(double to, std::stop_token stop) {
  const auto expected = wheel_->StartMove(to);
  if (!expected) return expected.error();
  // As arms do (acquisition/motion.cpp): a turn that took too long may still have arrived.
  const auto still = wheel_->WaitUntilStill(1.5 * *expected + Seconds(2), std::move(stop));
  if (!still && still.error().code != ErrorCode::kTimeout) return still;
  return {};
}

Result<void> FilterWheelLight::Turn(double from, double to, std::stop_token stop) {
  if (const auto turning = TurningPoint(from, to, wheel_->limits())) {
    if (auto turned = Leg(*turning, stop); !turned) return turned;
  }
  return Leg(to, std::move(stop));
}

Result<void> FilterWheelLight::Select(LightColour colour, std::stop_token stop) {
  auto state = wheel_->State();
  if (!state) return state.error();
  if (!state->homed) {
    if (auto homed = wheel_->Home(stop); !homed) return homed;
    state = wheel_->State();
  }
  const double target = PositionOf(settings_, colour);
  for (int n = 0; state && !IsAt(state->position, colour) && n <= settings_.retries; ++n) {
    if (auto turned = Turn(state->position, target, stop); !turned) return turned;
    state = wheel_->State();
  }
  if (!state) return state.error();
  if (IsAt(state->position, colour)) return {};
  return Error{
      ErrorCode::kRefused,
      fmt::format("{}: stands at {:.4f} deg after {} turns to {:.4f} deg, tolerance {} deg",
                  wheel_->name(), DegFromRad(state->position), settings_.retries + 1,
                  DegFromRad(target), DegFromRad(wheel_->limits().position_tolerance))};
}

Result<std::optional<LightColour>> FilterWheelLight::Selected() {
  const auto level = light_->Level();
  if (!level) return level.error();
  const auto state = wheel_->State();
  if (!state) return state.error();
  std::optional<LightColour> there;
  if (*level == 0 || state->moving || !state->homed) return there;
  for (const LightColour colour : kLightColours) {
    if (IsAt(state->position, colour)) there = colour;
  }
  return there;
}

}  // namespace gonio
