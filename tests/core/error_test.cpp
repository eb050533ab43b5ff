// SPDX-License-Identifier: Apache-2.0
#include "core/error.h"

#include <gtest/gtest.h>

#include <memory>
#include <set>
#include <string>
#include <utility>

namespace gonio {
namespace {

Result<int> Half(int n) {
  if (n % 2 != 0) return Error{ErrorCode::kRefused, "is odd"};
  return n / 2;
}

TEST(Result, HoldsAValue) {
  const Result<int> half = Half(6);
  ASSERT_TRUE(half.ok());
  EXPECT_TRUE(static_cast<bool>(half));
  EXPECT_EQ(half.value(), 3);
  EXPECT_EQ(*half, 3);
}

TEST(Result, HoldsTheErrorInstead) {
  const Result<int> half = Half(7);
  ASSERT_FALSE(half.ok());
  EXPECT_FALSE(static_cast<bool>(half));
  EXPECT_EQ(half.error().code, ErrorCode::kRefused);
  EXPECT_EQ(half.error().message, "is odd");
}

TEST(Result, CarriesWhatCanOnlyBeMoved) {
  const auto box = [](int n) -> Result<std::unique_ptr<int>> {
    if (n < 0) return Error{ErrorCode::kRefused, "is negative"};
    return std::make_unique<int>(n);
  };
  Result<std::unique_ptr<int>> five = box(5);
  const std::unique_ptr<int> taken = std::move(five).value();
  EXPECT_EQ(*taken, 5);
}

TEST(Result, LetsTheValueBeChangedInPlace) {
  Result<std::string> text(std::string("ab"));
  *text += "c";
  EXPECT_EQ(text->size(), 3u);
}

TEST(Result, OfVoidIsFineUnlessGivenAnError) {
  const Result<void> fine;
  EXPECT_TRUE(fine.ok());
  const Result<void> late(Error{ErrorCode::kTimeout, "no answer"});
  ASSERT_FALSE(late.ok());
  EXPECT_EQ(late.error().message, "no answer");
}

TEST(ResultDeathTest, AbortsWithTheErrorsMessageWhenTheValueIsTaken) {
  const Result<int> half = Half(7);
  EXPECT_DEATH((void)half.value(), "is odd");
}

TEST(ResultDeathTest, AbortsWhenTheErrorOfAValueIsAskedFor) {
  EXPECT_DEATH((void)Half(6).error(), "holds a value");
  EXPECT_DEATH((void)Result<void>().error(), "without one");
}

TEST(CheckDeathTest, NamesFileExpressionAndDetail) {
  EXPECT_DEATH(GONIO_CHECK(1 + 1 == 3, "arithmetic"),
               "error_test.cpp:.*check failed: 1 \\+ 1 == 3 \\(arithmetic\\)");
}

TEST(ErrorCode, HasADistinctWordForEachCode) {
  std::set<std::string> words;
  for (const ErrorCode code : {ErrorCode::kTimeout, ErrorCode::kDisconnected, ErrorCode::kProtocol,
                               ErrorCode::kRefused, ErrorCode::kCancelled, ErrorCode::kStorage}) {
    words.insert(ToString(code));
  }
  EXPECT_EQ(words.size(), 6u);
  EXPECT_FALSE(words.contains("unknown"));
}

}  // namespace
}  // namespace gonio
