// SPDX-License-Identifier: Apache-2.0
// Whatever comes from a GCS 2 controller's line is refused or in range.
#include <fmt/format.h>

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

#include "core/check.h"
#include "drivers/gcs2_codec.h"

namespace {

using namespace gonio::gcs2;

void Check(std::string_view line) {
  const auto flag = FlagOf(line, "1");
  const auto number = NumberOf(line, "1");
  const auto value = ValueOf(line, "1");
  if (flag) GONIO_CHECK(number && *number == (*flag ? 1 : 0), line);
  if (number) {
    GONIO_CHECK(std::isfinite(*number) && value, line);
    GONIO_CHECK(*NumberOf(fmt::format("1={}", *number), "1") == *number, line);
  }
  if (value) GONIO_CHECK(*UnitIn(line) == *value, line);
  if (const auto unit = UnitIn(line)) (void)IsDegrees(*unit);
  if (const auto moving = MovingIn(line)) {
    GONIO_CHECK(*MovingIn(fmt::format("{:X}", *moving)) == *moving, line);
  }
  if (const auto error = ErrorIn(line)) {
    GONIO_CHECK(!TextOf(*error).empty(), line);
    GONIO_CHECK(*ErrorIn(fmt::format("{}", *error)) == *error, line);
    GONIO_CHECK(!IsFault(*error) || IsError(*error), line);
  }
  if (const auto syntax = SyntaxIn(line)) GONIO_CHECK(std::isfinite(*syntax), line);
  if (const auto ready = ReadyIn(line)) GONIO_CHECK(line.size() == 1, line);
  if (const auto text = FromController(2, line)) {
    GONIO_CHECK(line == "0 2 " + *text, line);
    GONIO_CHECK(IsIdentity(*text) == IsIdentity(line), line);
  }
  GONIO_CHECK(NameIn(line).size() <= line.size(), line);
  (void)IsLastLine(line);
  (void)Shown(line);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  std::string_view rest(reinterpret_cast<const char*>(data), size);
  Check(rest);
  while (!rest.empty()) {
    const std::size_t end = rest.find('\n');
    Check(rest.substr(0, end));
    rest.remove_prefix(end == std::string_view::npos ? rest.size() : end + 1);
  }
  return 0;
}
