// SPDX-License-Identifier: Apache-2.0
#include "apps/gonio/interrupt.h"

#include <semaphore.h>

#include <cerrno>
#include <csignal>
#include <cstdio>
#include <thread>

#include "core/check.h"

namespace gonio {
namespace {

// A handler can do no more than this: sem_post is on the short list of what is safe in one. A
// thread does the rest, since stop callbacks may lock.
sem_t signals;
void OnSignal(int) {
  const int saved = errno;
  sem_post(&signals);
  errno = saved;
}

void WaitForSignal() {
  while (sem_wait(&signals) != 0 && errno == EINTR) {
  }
}

}  // namespace

struct Interrupt::Impl {
  std::stop_source after_pose;
  std::stop_source now;
  struct sigaction old_int {};
  struct sigaction old_term {};
  std::jthread watcher;

  void Watch(const std::stop_token& over) {
    WaitForSignal();
    if (over.stop_requested()) return;
    std::fputs("\ngonio: stopping after this pose; once more to stop the arms now\n", stderr);
    after_pose.request_stop();
    WaitForSignal();
    if (!over.stop_requested()) now.request_stop();
  }
};

Interrupt::Interrupt() : impl_(std::make_unique<Impl>()) {
  GONIO_CHECK(sem_init(&signals, 0, 0) == 0, "semaphore");
  impl_->watcher = std::jthread([impl = impl_.get()](std::stop_token over) { impl->Watch(over); });
  struct sigaction action {};
  action.sa_handler = OnSignal;
  action.sa_flags = SA_RESTART;
  sigemptyset(&action.sa_mask);
  sigaction(SIGINT, &action, &impl_->old_int);
  sigaction(SIGTERM, &action, &impl_->old_term);
}

Interrupt::~Interrupt() {
  sigaction(SIGINT, &impl_->old_int, nullptr);
  sigaction(SIGTERM, &impl_->old_term, nullptr);
  impl_->watcher.request_stop();
  sem_post(&signals);  // wakes the watcher wherever it waits: it looks at `over` first
  impl_->watcher.join();
  sem_destroy(&signals);
}

std::stop_token Interrupt::after_pose() const { return impl_->after_pose.get_token(); }
std::stop_token Interrupt::now() const { return impl_->now.get_token(); }

}  // namespace gonio
