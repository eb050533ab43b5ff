// SPDX-License-Identifier: Apache-2.0
// Whatever comes from an ESP301's line is refused or in range.
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

#include "core/check.h"
#include "drivers/esp301_codec.h"

namespace {

using namespace gonio::esp301;

void Check(std::string_view line) {
  GONIO_CHECK(!(IsUnasked(line) && IsVersion(line)), line);
  const auto flag = FlagIn(line, "MD?");
  const auto value = ValueIn(line, "TP?");
  if (value) GONIO_CHECK(std::isfinite(*value), line);
  if (flag) GONIO_CHECK(value && *value == (*flag ? 1 : 0), line);
  if (const auto unit = UnitIn(line)) {
    GONIO_CHECK(*unit >= 0 && *unit <= 11 && !TextOfUnit(*unit).empty(), line);
  }
  const auto error = ErrorIn(line);
  if (!error) return;
  GONIO_CHECK(error->axis >= 0 && error->axis <= 99 && error->number >= 0, line);
  GONIO_CHECK(value && *value == 100 * error->axis + error->number, line);
  GONIO_CHECK(!TextOf(*error).empty(), line);
  GONIO_CHECK(*ErrorIn(std::to_string(100 * error->axis + error->number)) == *error, line);
  (void)IsFault(*error);
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
