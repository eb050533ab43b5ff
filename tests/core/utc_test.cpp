// SPDX-License-Identifier: Apache-2.0
#include "core/utc.h"

#include <gtest/gtest.h>

namespace gonio {
namespace {

TEST(UtcText, GoesThereAndBack) {
  constexpr std::int64_t kSome = 1714727564;
  EXPECT_EQ(UtcText(kSome), "2024-05-03T09:12:44Z");
  EXPECT_EQ(SecondsOfUtc("2024-05-03T09:12:44Z"), kSome);
  for (const char* wrong : {"", "2024-05-03", "2024-02-30T00:00:00Z", "2024-05-03T24:00:00Z",
                            "2024-05-03T09:12:44Z ", "2024-5-03T09:12:44Z"}) {
    EXPECT_FALSE(SecondsOfUtc(wrong)) << wrong;
  }
}

}  // namespace
}  // namespace gonio
