// SPDX-License-Identifier: Apache-2.0
// Text that devices send, as numbers and in messages.
#include <algorithm>
#include <cmath>

#include "core/check.h"
#include "drivers/wire_text.h"
#include "tests/fuzz/scripted_link.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string text = gonio::TextOf(data, size);
  const std::string quoted = gonio::Quoted(text);
  GONIO_CHECK(quoted.size() <= 2 + 4 * 80 + 3, "a message stays short");
  GONIO_CHECK(std::all_of(quoted.begin(), quoted.end(), [](char c) { return c >= ' ' && c < 127; }),
              "a message is plain text");
  const auto number = gonio::NumberIn(text, "it");
  GONIO_CHECK(!number || std::isfinite(*number), "a number is finite");
  return 0;
}
