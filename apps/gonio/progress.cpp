// SPDX-License-Identifier: Apache-2.0
#include "apps/gonio/progress.h"

#include <fmt/format.h>
#include <unistd.h>

#include <cmath>
#include <cstdio>

namespace gonio {
namespace {

constexpr std::chrono::milliseconds kRefresh{100};

std::string Describe(const Progress& progress) {
  std::string text = fmt::format("pose {} of {}, {} on the rig", progress.poses, progress.max_poses,
                                 ForPeople(progress.elapsed));
  if (progress.predicted_error) {
    text += fmt::format(", predicted error {:.4f}", *progress.predicted_error);
  }
  if (progress.rejected > 0) text += fmt::format(", {} refused", progress.rejected);
  return text;
}

}  // namespace

std::string ForPeople(Seconds duration) {
  const auto total = static_cast<long long>(std::llround(duration.count()));
  if (total < 60) return fmt::format("{} s", total);
  if (total < 3600) return fmt::format("{} min {:02} s", total / 60, total % 60);
  const long long minutes = std::llround(duration.count() / 60);
  return fmt::format("{} h {:02} min", minutes / 60, minutes % 60);
}

ProgressLine::ProgressLine(std::string title, bool quiet)
    : title_(std::move(title)), quiet_(quiet), terminal_(isatty(STDOUT_FILENO) != 0) {}

void ProgressLine::Show(const Progress& progress) {
  Show(progress.poses, progress.max_poses, Describe(progress));
}

void ProgressLine::Show(int done, int total, const std::string& text) {
  if (quiet_) return;
  const auto now = std::chrono::steady_clock::now();
  const bool last = done >= total;
  left_.Show(done, now - begin_);
  if (terminal_) {
    if (!last && now - shown_ < kRefresh) return;
    shown_ = now;
    // Waiting time, not the rig's: on a simulated rig they are far apart.
    fmt::print("\r\033[K{}: {}{}", title_, text, Left(std::max(total - done, 0)));
    dirty_ = true;
  } else {
    const int tenths = total > 0 ? 10 * done / total : 10;
    if (tenths <= tenths_shown_) return;
    tenths_shown_ = tenths;
    fmt::print("{}: {}\n", title_, text);
  }
  std::fflush(stdout);
}

// "; at most 12 min 05 s left, 11 min 40 s to 12 min 30 s": a plan may end before its budget.
std::string ProgressLine::Left(int steps) const {
  const auto left = left_.For(steps);
  if (!left) return {};
  return fmt::format("; at most {} left, {} to {}", ForPeople(left->expected), ForPeople(left->low),
                     ForPeople(left->high));
}

void ProgressLine::Finish() {
  if (dirty_) std::fputs("\r\033[K", stdout);
  std::fflush(stdout);
  dirty_ = false;
}

}  // namespace gonio
