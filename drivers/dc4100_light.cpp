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
  (void)Set(fmt::format("o {} 0", settings_.channel)).ok();
}

Result<void> Dc4100Light::Prepare() {
  const auto model = Ask("n?");
  if (!model) return model.error();
  const auto serial = Ask("s?");
  if (!serial) return serial.error();
  const auto firmware = Ask("v?");
  if (!firmware) return firmware.error();
  if (const auto off = SetTo("o", 0); !off) return off;
  const auto limit = Number("l?");
  if (!limit) return limit.error();
  const auto most = Number("ml?");
  if (!most) return most.error();
  const double highest = kMilli * std::min(*limit, *most);
  // Also true of NaN.
  if (!(settings_.full_current > 0 && settings_.full_current <= highest)) {
    return Refused(
        fmt::format("a full current of {:.4g} A is outside 0 .. {:.4g} A, the limit of "
                    "channel {}",
                    settings_.full_current, highest, settings_.channel));
  }
  if (const auto mode = Set("m 0"); !mode) return mode;
  const auto head = AskChannel("hs?");
  if (!head) return head.error();
  const auto wavelength = AskChannel("wl?");
  if (!wavelength) return wavelength.error();
  identity_ = fmt::format(
      "{} {} {}, channel {}: LED {}, {}, constant current, full {:.4g} A, limit {:.4g} A", *model,
      *serial, *firmware, settings_.channel, *head, *wavelength, settings_.full_current, highest);
  return {};
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

Result<std::string> Dc4100Light::AskChannel(const std::string& question) {
  return Ask(fmt::format("{} {}", question, settings_.channel));
}

Result<double> Dc4100Light::Number(const std::string& question) {
  const std::string asked = fmt::format("{} {}", question, settings_.channel);
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

Result<void> Dc4100Light::SetTo(const std::string& setting, int value) {
  const auto set = Set(fmt::format("{} {} {}", setting, settings_.channel, value));
  if (!set) return set;
  const auto got = Number(setting + "?");
  if (!got) return got.error();
  if (*got == value) return {};
  return Refused(
      fmt::format("{}: {} was set to {} and reads {:.6g}", link_->name(), setting, value, *got));
}

Result<void> Dc4100Light::SetLevel(double level) {
  // Also true of NaN.
  if (!(level >= 0 && level <= 1)) {
    return Named(Refused(fmt::format("set level: {} is outside 0 .. 1", level)));
  }
  const int milliamperes = static_cast<int>(std::lround(level * settings_.full_current / kMilli));
  auto done = level == 0 ? SetTo("o", 0) : SetTo("cc", milliamperes);
  if (done && level > 0) done = SetTo("o", 1);
  return done ? done : Named(done.error());
}

Result<double> Dc4100Light::Level() {
  const auto on = Number("o?");
  if (!on) return Named(on.error());
  if (*on == 0) return 0.0;
  const auto milliamperes = Number("cc?");
  if (!milliamperes) return Named(milliamperes.error());
  return kMilli * *milliamperes / settings_.full_current;
}

Error Dc4100Light::Named(const Error& error) const {
  return {error.code, fmt::format("{}: {}", name(), error.message)};
}

}  // namespace gonio
