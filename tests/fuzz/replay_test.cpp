// SPDX-License-Identifier: Apache-2.0
// The seeds of all fuzz targets, and what is left of them when bytes are missing or wrong. Finds
// less than script/fuzz, but runs wherever the tests do, under the same sanitizers.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <ostream>
#include <string>
#include <vector>

#include "core/file.h"
#include "fuzz_targets.h"

namespace gonio {

std::ostream& operator<<(std::ostream& out, const FuzzTarget& target) { return out << target.name; }

namespace {

class FuzzSeeds : public testing::TestWithParam<FuzzTarget> {
 protected:
  static std::vector<std::string> Seeds() {
    const auto folder =
        std::filesystem::path(GONIO_SOURCE_DIR) / "tests" / "fuzz" / "corpus" / GetParam().name;
    std::vector<std::string> seeds;
    if (!std::filesystem::exists(folder)) return seeds;
    for (const auto& entry : std::filesystem::directory_iterator(folder)) {
      seeds.push_back(ReadTextFile(entry.path()));
    }
    return seeds;
  }
  // From memory of its own, so that reading one byte too many is noticed.
  static void Feed(std::string_view bytes) {
    const std::vector<std::uint8_t> data(bytes.begin(), bytes.end());
    EXPECT_EQ(GetParam().feed(data.data(), data.size()), 0);
  }
};

TEST_P(FuzzSeeds, AreTaken) {
  const std::vector<std::string> seeds = Seeds();
  ASSERT_FALSE(seeds.empty()) << "no seeds in tests/fuzz/corpus/" << GetParam().name;
  Feed({});
  for (const std::string& seed : seeds) Feed(seed);
}

TEST_P(FuzzSeeds, AreTakenCutShort) {
  for (const std::string& seed : Seeds()) {
    for (std::size_t size = 0; size < std::min<std::size_t>(seed.size(), 512); ++size) {
      Feed(std::string_view(seed).substr(0, size));
    }
  }
}

TEST_P(FuzzSeeds, AreTakenWithOneByteWrong) {
  for (const std::string& seed : Seeds()) {
    for (std::size_t at = 0; at < std::min<std::size_t>(seed.size(), 512); ++at) {
      for (const char wrong : {'\0', '9', '-', '\n', '\x7f', '\xff'}) {
        std::string bytes = seed;
        bytes[at] = wrong;
        Feed(bytes);
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(All, FuzzSeeds, testing::ValuesIn(kFuzzTargets),
                         [](const auto& of) { return std::string(of.param.name); });

}  // namespace
}  // namespace gonio
