// SPDX-License-Identifier: Apache-2.0
#include "apps/gonio/text_difference.h"

#include <gtest/gtest.h>

namespace gonio {
namespace {

TEST(TextDifference, OfTheSameIsEmpty) {
  EXPECT_EQ(TextDifference("", ""), "");
  EXPECT_EQ(TextDifference("a\nb\n", "a\nb\n"), "");
}

TEST(TextDifference, NamesLinesWithTheirNumbers) {
  EXPECT_EQ(TextDifference("a\nb\nc\n", "a\nx\nc\nd\n"), "  - 2: b\n  + 2: x\n  + 4: d\n");
}

// Example failure is a comparison line by line, after which everything is another.
TEST(TextDifference, ALineThatWasPutInMovesTheOthers) {
  EXPECT_EQ(TextDifference("a\nb\nc\n", "new\na\nb\nc\n"), "  + 1: new\n");
  EXPECT_EQ(TextDifference("new\na\nb\nc\n", "a\nb\nc\n"), "  - 1: new\n");
  EXPECT_EQ(TextDifference("a\n", ""), "  - 1: a\n");
}

}  // namespace
}  // namespace gonio
