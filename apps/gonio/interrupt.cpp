// SPDX-License-Identifier: Apache-2.0
#include "apps/gonio/interrupt.h"

#include <poll.h>
#include <semaphore.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cerrno>
#include <csignal>
#include <cstdint>
#include <cstdio>
#include <thread>

#include "core/check.h"

namespace gonio {
namespace {

constexpr int kSignals[] = {SIGINT, SIGTERM, SIGHUP, SIGUSR1};

// A handler can do no more than this: sem_post is on the short list of what is safe in one. A
// thread does the rest, since stop callbacks may lock.
sem_t signals;
std::atomic<int> last_signal{0};
static_assert(std::atomic<int>::is_always_lock_free);

void OnSignal(int signal) {
  const int saved = errno;
  last_signal = signal;
  sem_post(&signals);
  errno = saved;
}

void WaitForSignal() {
  while (sem_wait(&signals) != 0 && errno == EINTR) {
  }
}

void Say(const char* text) { std::fputs(text, stderr); }

}  // namespace

struct Interrupt::Impl {
  enum class Phase { kRunning, kPausing, kPaused, kStopping, kAborting };

  const int keyboard;
  int wake = ::eventfd(0, EFD_CLOEXEC);  // ends a wait for Enter
  std::atomic<Phase> phase{Phase::kRunning};
  std::stop_source after_pose;
  std::stop_source now;
  std::array<struct sigaction, std::size(kSignals)> old{};
  std::jthread watcher;

  explicit Impl(int keys) : keyboard(keys) {}
  ~Impl() { ::close(wake); }

  void Wake() const {
    const std::uint64_t one = 1;
    (void)!::write(wake, &one, sizeof one);
  }

  void Stop(const char* what) {
    Say(what);
    phase = Phase::kStopping;
    after_pose.request_stop();
  }

  void Act(int signal) {
    if (signal == SIGUSR1) {
      Phase expected = Phase::kPaused;
      phase.compare_exchange_strong(expected, Phase::kRunning);
      return;
    }
    switch (phase) {
      case Phase::kRunning:
        if (signal == SIGINT && keyboard >= 0) {
          Say("\ngonio: pausing after this pose; once more to stop the arms now\n");
          phase = Phase::kPausing;
        } else {
          Stop("\ngonio: stopping after this pose; once more to stop the arms now\n");
        }
        return;
      case Phase::kPaused:
        Stop("\ngonio: ending the session; gonio run --resume goes on with it\n");
        return;
      case Phase::kPausing:
      case Phase::kStopping:
        Say("\ngonio: stopping the arms; once more to end at once, whatever they do\n");
        phase = Phase::kAborting;
        now.request_stop();
        return;
      case Phase::kAborting:
        ::_exit(128 + signal);
    }
  }

  void Watch(const std::stop_token& over) {
    for (;;) {
      WaitForSignal();
      if (over.stop_requested()) return;
      Act(last_signal);
      Wake();
    }
  }
};

Interrupt::Interrupt(int keyboard) : impl_(std::make_unique<Impl>(keyboard)) {
  GONIO_CHECK(sem_init(&signals, 0, 0) == 0, "semaphore");
  GONIO_CHECK(impl_->wake >= 0, "eventfd");
  impl_->watcher = std::jthread([impl = impl_.get()](std::stop_token over) { impl->Watch(over); });
  struct sigaction action {};
  action.sa_handler = OnSignal;
  action.sa_flags = SA_RESTART;
  sigemptyset(&action.sa_mask);
  for (std::size_t i = 0; i < std::size(kSignals); ++i) {
    sigaction(kSignals[i], nullptr, &impl_->old[i]);
    if (kSignals[i] == SIGHUP && impl_->old[i].sa_handler == SIG_IGN) continue;
    sigaction(kSignals[i], &action, nullptr);
  }
}

Interrupt::~Interrupt() {
  for (std::size_t i = 0; i < std::size(kSignals); ++i) {
    sigaction(kSignals[i], &impl_->old[i], nullptr);
  }
  impl_->watcher.request_stop();
  sem_post(&signals);  // wakes the watcher wherever it waits: it looks at `over` first
  impl_->watcher.join();
  sem_destroy(&signals);
}

std::stop_token Interrupt::after_pose() const { return impl_->after_pose.get_token(); }
std::stop_token Interrupt::now() const { return impl_->now.get_token(); }
bool Interrupt::pausing() const { return impl_->phase == Impl::Phase::kPausing; }

void Interrupt::WaitWhilePaused() {
  for (const Impl::Phase from : {Impl::Phase::kPausing, Impl::Phase::kRunning}) {
    Impl::Phase expected = from;
    if (impl_->phase.compare_exchange_strong(expected, Impl::Phase::kPaused)) break;
  }
  if (impl_->keyboard >= 0) {
    Say("gonio: paused; Enter goes on, Ctrl-C ends the session\n");
  } else {
    Say("gonio: paused; SIGUSR1 goes on, SIGTERM ends the session\n");
  }
  while (impl_->phase == Impl::Phase::kPaused) {
    std::array<pollfd, 2> ready{{{impl_->keyboard, POLLIN, 0}, {impl_->wake, POLLIN, 0}}};
    if (::poll(ready.data(), ready.size(), -1) < 0) continue;
    if (ready[1].revents != 0) {
      std::uint64_t count = 0;
      (void)!::read(impl_->wake, &count, sizeof count);
    }
    if (ready[0].revents == 0) continue;
    std::array<char, 256> line{};
    if (::read(impl_->keyboard, line.data(), line.size()) <= 0) {
      impl_->Stop("gonio: nobody is there any more; ending the session\n");
      return;
    }
    Impl::Phase expected = Impl::Phase::kPaused;
    impl_->phase.compare_exchange_strong(expected, Impl::Phase::kRunning);
  }
}

}  // namespace gonio
