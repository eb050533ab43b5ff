// SPDX-License-Identifier: Apache-2.0
#include "apps/gonio/text_difference.h"

#include <fmt/format.h>

#include <algorithm>
#include <sstream>
#include <vector>

namespace gonio {
namespace {

std::vector<std::string> LinesOf(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream in(text);
  for (std::string line; std::getline(in, line);) lines.push_back(line);
  return lines;
}

}  // namespace

std::string TextDifference(const std::string& before, const std::string& now) {
  const std::vector<std::string> a = LinesOf(before);
  const std::vector<std::string> b = LinesOf(now);
  // common[i][j]: lines that a from i and b from j have in common, in order.
  std::vector<std::vector<int>> common(a.size() + 1, std::vector<int>(b.size() + 1, 0));
  for (std::size_t i = a.size(); i-- > 0;) {
    for (std::size_t j = b.size(); j-- > 0;) {
      common[i][j] =
          a[i] == b[j] ? common[i + 1][j + 1] + 1 : std::max(common[i + 1][j], common[i][j + 1]);
    }
  }
  std::string text;
  std::size_t i = 0;
  std::size_t j = 0;
  while (i < a.size() || j < b.size()) {
    if (i < a.size() && j < b.size() && a[i] == b[j]) {
      ++i;
      ++j;
    } else if (j == b.size() || (i < a.size() && common[i + 1][j] >= common[i][j + 1])) {
      text += fmt::format("  - {}: {}\n", i + 1, a[i]);
      ++i;
    } else {
      text += fmt::format("  + {}: {}\n", j + 1, b[j]);
      ++j;
    }
  }
  return text;
}

}  // namespace gonio
