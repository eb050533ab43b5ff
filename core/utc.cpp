// SPDX-License-Identifier: Apache-2.0
#include "core/utc.h"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <chrono>
#include <cstdio>
#include <ctime>

namespace gonio {

std::string UtcText(std::int64_t seconds) {
  return fmt::format("{:%Y-%m-%dT%H:%M:%SZ}", fmt::gmtime(static_cast<std::time_t>(seconds)));
}

std::optional<std::int64_t> SecondsOfUtc(const std::string& text) {
  int y = 0;
  unsigned month = 0, d = 0, h = 0, m = 0, s = 0;
  if (std::sscanf(text.c_str(), "%4d-%2u-%2uT%2u:%2u:%2uZ", &y, &month, &d, &h, &m, &s) != 6) {
    return std::nullopt;
  }
  const std::chrono::year_month_day date{std::chrono::year(y), std::chrono::month(month),
                                         std::chrono::day(d)};
  if (!date.ok()) return std::nullopt;
  const std::int64_t days = std::chrono::sys_days(date).time_since_epoch().count();
  const std::int64_t seconds = days * 86400 + h * 3600 + m * 60 + s;
  // Whatever is not written like this is not such a date.
  return UtcText(seconds) == text ? std::optional(seconds) : std::nullopt;
}

}  // namespace gonio
