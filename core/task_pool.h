// SPDX-License-Identifier: Apache-2.0
// Independent tasks over the cores.

#pragma once

#include <cstddef>
#include <functional>
#include <stop_token>

namespace gonio {

// `wanted`, or as many threads as there are cores if that is 0.
int ThreadsOr(int wanted);

// Calls task(0) .. task(count - 1), each once and in this order if `threads` is 1. Tasks begun when
// `stop` is requested are finished, no others. After an exception no task is begun any more; the
// first one is thrown again here.
void ForEachTask(std::size_t count, int threads, const std::stop_token& stop,
                 const std::function<void(std::size_t)>& task);

}  // namespace gonio
