// SPDX-License-Identifier: Apache-2.0
#include "drivers/dc4100_light.h"

#include <fmt/format.h>

#include <cmath>
#include <utility>

#include "drivers/asked_twice.h"
#include "drivers/wire_text.h"

namespace gonio {
namespace {

constexpr double kMilli = 1e-3;

Error Refused(std::string message) { return {ErrorCode::kRefused, std::move(message)}; }

// The number of "ERROR 3:text".
Result<double> CodeOf(std::string_view answer) {
  constexpr std::string_view kBefore = "ERROR ";
  const std::string_view rest =
      answer.substr(0, kBefore.size()) == kBefore ? answer.substr(kBefore.size()) : "";
  const auto code = NumberIn(rest.substr(0, rest.find(':')), "e?");
  if (code) return code;
  return Error{ErrorCode::kProtocol, fmt::format("{} does not answer e?", Quoted(answer))};
}

}  // namespace

Result<std::unique_ptr<Light>> Dc4100Light::Open(std::unique_ptr<ByteLink> link,
                                                 const Dc4100Settings& settings) {
  std::unique_ptr<Dc4100Light> light(new Dc4100Light(std::move(link), settings));
  if (const auto prepared = light->Prepare(); !prepared) return light->Named(prepared.error());
  return std::unique_ptr<Light>(std::move(light));
}

Dc4100Light::~Dc4100Light() {
  // It is too late to tell anybody that it failed.
  for (const Dc4100Led& led : settings_.leds) (void)Set(fmt::format("o {} 0", led.channel)).ok();
}

Result<void> Dc4100Light::Prepare() {
  const auto model = Ask("n?");
  if (!model) return model.error();
  const auto serial = Ask("s?");
  if (!serial) return serial.error();
  const auto firmware = Ask("v?");
  if (!firmware) return firmware.error();
  if (const auto off = SwitchOff(); !off) return off;
  if (const auto mode = Set("m 0"); !mode) return mode;
  identity_ = fmt::format("{} {} {}", *model, *serial, *firmware);
  for (std::size_t i = 0; i < settings_.leds.size(); ++i) {
    const auto text = PrepareLed(settings_.leds[i]);
    if (!text) return text.error();
    const std::string colour = has_colours() ? ToString(kLightColours[i]) + std::string(" ") : "";
    identity_ += fmt::format("{} {}{}", i == 0 ? "," : ";", colour, *text);
  }
  return {};
}

Result<void> Dc4100Light::SwitchOff() {
  if (has_colours()) {
    if (const auto all = Set("o -1 0"); !all) return all;
  }
  for (const Dc4100Led& led : settings_.leds) {
    if (const auto off = SetTo("o", led.channel, 0); !off) return off;
  }
  return {};
}

Result<std::string> Dc4100Light::PrepareLed(const Dc4100Led& led) {
  const auto limit = Number("l?", led.channel);
  if (!limit) return limit.error();
  const auto most = Number("ml?", led.channel);
  if (!most) return most.error();
  const double highest = kMilli * std::min(*limit, *most);
  // Also true of NaN.
  if (!(led.full_current > 0 && led.full_current <= highest)) {
    return Refused(
        fmt::format("a full current of {:.4g} A is outside 0 .. {:.4g} A, the limit of "
                    "channel {}",
                    led.full_current, highest, led.channel));
  }
  const auto head = Ask(fmt::format("hs? {}", led.channel));
  if (!head) return head.error();
  const auto wavelength = Ask(fmt::format("wl? {}", led.channel));
  if (!wavelength) return wavelength.error();
  return fmt::format("channel {}: LED {}, {}, constant current, full {:.4g} A, limit {:.4g} A",
                     led.channel, *head, *wavelength, led.full_current, highest);
}

Result<std::string> Dc4100Light::Exchange(const std::string& question) {
  // What is still there belongs to questions that were given up.
  if (const auto discarded = lines_.Discard(); !discarded) return discarded.error();
  const auto sent = link_->Write(question + "\r\n", settings_.reply_limit);
  if (!sent) return sent.error();
  auto line = lines_.Next(settings_.reply_limit);
  if (line) return line;
  return Error{line.error().code, fmt::format("{}, asked {}", line.error().message, question)};
}

Result<std::string> Dc4100Light::Ask(const std::string& question) {
  return AskedTwice([&] { return Exchange(question); });
}

Result<double> Dc4100Light::Number(const std::string& question, int channel) {
  const std::string asked = fmt::format("{} {}", question, channel);
  return AskedTwice([&]() -> Result<double> {
    const auto answer = Exchange(asked);
    return answer ? NumberIn(*answer, fmt::format("{}: {}", link_->name(), asked)) : answer.error();
  });
}

Result<void> Dc4100Light::Set(const std::string& command) {
  // An error left over from before must not be taken for this command's.
  if (const auto before = Exchange("e?"); !before) return before.error();
  const auto sent = link_->Write(command + "\r\n", settings_.reply_limit);
  if (!sent) return sent.error();
  const auto answer = Exchange("e?");
  if (!answer) return answer.error();
  const auto code = CodeOf(*answer);
  if (!code) return Error{code.error().code, link_->name() + ": " + code.error().message};
  if (*code == 0) return {};
  return Refused(fmt::format("{}: refused \"{}\": {}", link_->name(), command, Quoted(*answer)));
}

Result<void> Dc4100Light::SetTo(const std::string& setting, int channel, int value) {
  const auto set = Set(fmt::format("{} {} {}", setting, channel, value));
  if (!set) return set;
  const auto got = Number(setting + "?", channel);
  if (!got) return got.error();
  if (*got == value) return {};
  return Refused(fmt::format("{}: {} of channel {} was set to {} and reads {:.6g}", link_->name(),
                             setting, channel, value, *got));
}

Result<void> Dc4100Light::Drive(double level) {
  const auto milliamperes = static_cast<int>(std::lround(level * lit().full_current / kMilli));
  const auto set =
      level == 0 ? SetTo("o", lit().channel, 0) : SetTo("cc", lit().channel, milliamperes);
  return set && level > 0 ? SetTo("o", lit().channel, 1) : set;
}

Result<void> Dc4100Light::SetLevel(double level) {
  // Also true of NaN.
  if (!(level >= 0 && level <= 1)) {
    return Named(Refused(fmt::format("set level: {} is outside 0 .. 1", level)));
  }
  const auto done = Drive(level);
  return done ? done : Named(done.error());
}

Result<double> Dc4100Light::LitLevel() {
  const auto on = Number("o?", lit().channel);
  if (!on) return on.error();
  if (*on == 0) return 0.0;
  const auto milliamperes = Number("cc?", lit().channel);
  if (!milliamperes) return milliamperes.error();
  return kMilli * *milliamperes / lit().full_current;
}

Result<double> Dc4100Light::Level() {
  auto level = LitLevel();
  return level ? level : Named(level.error());
}

Result<void> Dc4100Light::Change(std::size_t led) {
  const auto level = LitLevel();
  if (!level) return level.error();
  for (const Dc4100Led& other : settings_.leds) {
    if (&other == &settings_.leds[led]) continue;
    if (const auto off = SetTo("o", other.channel, 0); !off) return off;
  }
  selected_ = led;
  return Drive(*level);
}

Result<void> Dc4100Light::Select(LightColour colour, std::stop_token stop) {
  if (!has_colours()) return Light::Select(colour, std::move(stop));
  const auto done = Change(static_cast<std::size_t>(colour));
  return done ? done : Named(done.error());
}

Result<std::optional<LightColour>> Dc4100Light::Lit() {
  std::optional<LightColour> lit;
  for (const LightColour colour : kLightColours) {
    const auto on = Number("o?", settings_.leds[static_cast<std::size_t>(colour)].channel);
    if (!on) return on.error();
    if (*on == 0) continue;
    if (lit) {
      return Error{ErrorCode::kProtocol,
                   fmt::format("{}: {} and {} are on at the same time", link_->name(),
                               ToString(*lit), ToString(colour))};
    }
    lit = colour;
  }
  return lit;
}

Result<std::optional<LightColour>> Dc4100Light::Selected() {
  if (!has_colours()) return std::optional<LightColour>();
  auto lit = Lit();
  return lit ? lit : Named(lit.error());
}

Error Dc4100Light::Named(const Error& error) const {
  return {error.code, fmt::format("{}: {}", name(), error.message)};
}

}  // namespace gonio
