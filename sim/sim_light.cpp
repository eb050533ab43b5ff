// SPDX-License-Identifier: Apache-2.0
#include "sim/sim_light.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/units.h"

namespace gonio {

double SlowDrift(double per_hour, Seconds time) {
  constexpr double kPeriod = 8;  // hours
  const double amplitude = per_hour * kPeriod / (2 * kPi);
  return 1 + amplitude * std::sin(2 * kPi * (time.count() / 3600) / kPeriod);
}

Rgb SpectrumOf(const std::optional<LightColour>& colour, double crosstalk) {
  Rgb light = Rgb::Zero();
  if (!colour) return light;
  const int own = static_cast<int>(*colour);
  for (int c = 0; c < kChannels; ++c) {
    if (c == own) light[c] += 1;
    if (std::abs(c - own) != 1) continue;
    light[c] += crosstalk;
    light[own] -= crosstalk;
  }
  return kChannels * light;
}

void SimLamp::GiveColours(double crosstalk) {
  led_ = LightColour::kRed;
  crosstalk_ = crosstalk;
}

void SimLamp::SetFilter(Filter filter, double crosstalk) {
  filter_ = std::move(filter);
  crosstalk_ = crosstalk;
}

std::optional<LightColour> SimLamp::ColourAt(Seconds time) const {
  return filter_ ? filter_(time) : led_;
}

Rgb SimLamp::SpectrumAt(Seconds time) const {
  return filter_ || led_ ? SpectrumOf(ColourAt(time), crosstalk_) : Rgb::Ones();
}

double SimLamp::PowerAt(Seconds time) const {
  if (faults_.fails_at > Seconds::zero() && time >= faults_.fails_at) return 0;
  double power = level_ * SlowDrift(drift_per_hour_, time);
  if (faults_.flicker > 0) {
    const auto slot = static_cast<std::uint64_t>(std::llround(time.count() * 1e3));
    power *= std::max(0.0, 1 + faults_.flicker * Random(faults_.seed, slot).Normal());
  }
  return power;
}

SimLight::SimLight(std::string name, std::shared_ptr<SimLamp> lamp)
    : name_(std::move(name)),
      identity_(lamp->has_colours() ? "simulated, red, green and blue" : "simulated"),
      lamp_(std::move(lamp)) {}

SimLight::~SimLight() { lamp_->set_level(0); }

Result<void> SimLight::SetLevel(double level) {
  // Also true of NaN.
  if (!(level >= 0 && level <= 1)) {
    return Error{ErrorCode::kRefused,
                 fmt::format("{}: set level: {} is outside 0 .. 1", name_, level)};
  }
  lamp_->set_level(level);
  return {};
}

Result<double> SimLight::Level() { return lamp_->level(); }

Result<void> SimLight::Select(LightColour colour, std::stop_token stop) {
  if (!has_colours()) return Light::Select(colour, std::move(stop));
  lamp_->Select(colour);
  return {};
}

Result<std::optional<LightColour>> SimLight::Selected() {
  return lamp_->level() > 0 ? lamp_->ColourAt(Seconds(0)) : std::nullopt;
}

SimMonitor::SimMonitor(std::string name, std::shared_ptr<const SimLamp> lamp, double noise,
                       const Clock& clock, Random random)
    : name_(std::move(name)),
      lamp_(std::move(lamp)),
      noise_(noise),
      clock_(clock),
      random_(random) {}

Result<double> SimMonitor::Read() {
  return lamp_->PowerAt(clock_.Now()) * (1 + noise_ * random_.Normal());
}

}  // namespace gonio
