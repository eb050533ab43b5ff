// SPDX-License-Identifier: Apache-2.0
#include "drivers/dc2200_light.h"

#include <fmt/format.h>

#include <cmath>
#include <utility>

namespace gonio {
namespace {

// The device's own spelling, with one R.
constexpr const char* kCurrent = "SOURCE1:CCURENT:CURRENT";
constexpr double kRounding = 2e-3;  // share of the full current that a set-point may be rounded by

Error Refused(std::string message) { return {ErrorCode::kRefused, std::move(message)}; }

}  // namespace

Result<std::unique_ptr<Light>> Dc2200Light::Open(std::unique_ptr<MessageLink> link,
                                                 const Dc2200Settings& settings) {
  auto driver = scpi::Instrument::Open(std::move(link), settings.reply_limit);
  if (!driver) {
    return Error{driver.error().code, settings.name + ": " + driver.error().message};
  }
  const std::string& identity = (*driver)->identity();
  if (identity.find("DC2200") == std::string::npos) {
    return Refused(
        fmt::format("{}: {} is no DC2200 but {}", settings.name, (*driver)->name(), identity));
  }
  std::unique_ptr<Dc2200Light> light(new Dc2200Light(std::move(driver).value(), settings));
  if (const auto prepared = light->Prepare(); !prepared) return light->Named(prepared.error());
  return std::unique_ptr<Light>(std::move(light));
}

Dc2200Light::~Dc2200Light() {
  // It is too late to tell anybody that it failed.
  (void)driver_->Command("OUTPUT1:STATE OFF").ok();
}

Result<void> Dc2200Light::Prepare() {
  if (const auto off = Switch(false); !off) return off;
  const auto limit = driver_->Number("SOURCE1:CURRENT:LIMIT?");
  if (!limit) return limit.error();
  // Also true of NaN.
  if (!(settings_.full_current > 0 && settings_.full_current <= *limit)) {
    return Refused(
        fmt::format("a full current of {:.4g} A is outside 0 .. {:.4g} A, the limit set "
                    "on the driver",
                    settings_.full_current, *limit));
  }
  if (const auto mode = driver_->Command("SOURCE1:MODE CC"); !mode) return mode;
  if (const auto set = SetCurrent(settings_.full_current); !set) return set;
  identity_ = fmt::format("{}, constant current, full {:.4g} A, limit {:.4g} A",
                          driver_->identity(), settings_.full_current, *limit);
  return {};
}

Result<void> Dc2200Light::Switch(bool on) {
  const auto set = driver_->Command(fmt::format("OUTPUT1:STATE {}", on ? "ON" : "OFF"));
  if (!set) return set;
  const auto state = driver_->Number("OUTPUT1:STATE?");
  if (!state) return state.error();
  if (*state == (on ? 1 : 0)) return {};
  return Refused(fmt::format("the output was switched {} and reads {:.6g}; is an LED connected?",
                             on ? "on" : "off", *state));
}

Result<void> Dc2200Light::SetCurrent(double current) {
  const auto set = driver_->Command(fmt::format("{} {:.6f}", kCurrent, current));
  if (!set) return set;
  const auto got = driver_->Number(fmt::format("{}?", kCurrent));
  if (!got) return got.error();
  if (std::abs(*got - current) <= kRounding * settings_.full_current) return {};
  return Refused(fmt::format("the current was set to {:.6g} A and reads {:.6g} A", current, *got));
}

Result<void> Dc2200Light::SetLevel(double level) {
  // Also true of NaN.
  if (!(level >= 0 && level <= 1)) {
    return Named(Refused(fmt::format("set level: {} is outside 0 .. 1", level)));
  }
  // Off is the output's doing: a current of zero is not dark on every driver.
  auto done = level == 0 ? Switch(false) : SetCurrent(level * settings_.full_current);
  if (done && level > 0) done = Switch(true);
  return done ? done : Named(done.error());
}

Result<double> Dc2200Light::Level() {
  const auto current = driver_->Number("SENSE3:CURRENT:DATA?");
  if (!current) return Named(current.error());
  return *current / settings_.full_current;
}

Error Dc2200Light::Named(const Error& error) const {
  return {error.code, fmt::format("{}: {}", name(), error.message)};
}

}  // namespace gonio
