// SPDX-License-Identifier: Apache-2.0
// Lines that arrive in any pieces: the same as if they had come at once.
#include "core/check.h"
#include "drivers/line_reader.h"
#include "tests/fuzz/scripted_link.h"

namespace gonio {
namespace {

// The first `count` lines of `text`.
std::string LinesOf(const std::string& text, std::size_t count) {
  std::string lines;
  for (const char c : text) {
    if (count == 0) break;
    if (c == '\n') --count;
    if (c != '\r') lines += c;
  }
  return lines;
}

}  // namespace
}  // namespace gonio

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  gonio::ScriptedLink link(gonio::TextOf(data, size));
  gonio::LineReader reader(&link);
  std::string lines;
  std::size_t count = 0;
  while (true) {
    const auto line = reader.Next(gonio::Seconds(0));
    if (!line) {
      const gonio::ErrorCode code = line.error().code;
      if (code == gonio::ErrorCode::kTimeout) continue;
      // Too long: what was dropped is nobody's line. Gone: this was all.
      if (code == gonio::ErrorCode::kProtocol) return 0;
      break;
    }
    GONIO_CHECK(line->find_first_of("\r\n") == std::string::npos, "a line has no end in it");
    GONIO_CHECK(line->size() <= 2 * gonio::LineReader::kMostBytes, "a line is not endless");
    lines += *line + '\n';
    ++count;
  }
  GONIO_CHECK(lines == gonio::LinesOf(link.said(), count), "nothing is lost or made up");
  return 0;
}
