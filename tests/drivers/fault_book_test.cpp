// SPDX-License-Identifier: Apache-2.0
#include "drivers/fault_book.h"

#include <gtest/gtest.h>

namespace gonio {
namespace {

TEST(FaultBook, KeepsAFaultForTheAxisItIsAbout) {
  FaultBook book;
  EXPECT_EQ(book.After(0, 1), "");
  book.Note(2, "limit");
  EXPECT_EQ(book.After(0, 1), "");
  EXPECT_EQ(book.After(0, 2), "limit");
  EXPECT_EQ(book.After(0, 2), "limit") << "however often it is read";
}

TEST(FaultBook, KnowsWhatEachAxisHasBehindIt) {
  FaultBook book;
  book.Note(FaultBook::kAll, "emergency stop");
  const int behind = book.pages();
  EXPECT_EQ(book.After(behind, 1), "");
  EXPECT_EQ(book.After(0, 2), "emergency stop");
  book.Note(1, "following error");
  EXPECT_EQ(book.After(behind, 1), "following error");
  EXPECT_EQ(book.After(0, 1), "following error") << "the last one";
  EXPECT_EQ(book.After(0, 2), "emergency stop");
}

}  // namespace
}  // namespace gonio
