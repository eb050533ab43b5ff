// SPDX-License-Identifier: Apache-2.0
#include "core/task_pool.h"

#include <gtest/gtest.h>

#include <stdexcept>
#include <vector>

namespace gonio {
namespace {

TEST(ForEachTask, DoesEachOnceAndThrowsTheFirstError) {
  std::vector<int> calls(50, 0);
  ForEachTask(calls.size(), 4, {}, [&](std::size_t i) { ++calls[i]; });
  EXPECT_EQ(calls, std::vector<int>(50, 1));
  int begun = 0;
  const auto fail = [&](std::size_t i) {
    ++begun;
    if (i == 2) throw std::runtime_error("third");
  };
  EXPECT_THROW(ForEachTask(50, 1, {}, fail), std::runtime_error);
  EXPECT_EQ(begun, 3);
}

}  // namespace
}  // namespace gonio
