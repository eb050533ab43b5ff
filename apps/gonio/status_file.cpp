// SPDX-License-Identifier: Apache-2.0
#include "apps/gonio/status_file.h"

#include <unistd.h>

#include <ctime>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "core/file.h"
#include "core/utc.h"

namespace gonio {
namespace {

using nlohmann::json;

constexpr std::chrono::seconds kRefresh{1};

json Left(const TimeLeft& left, const Progress& progress) {
  const auto interval = left.For(std::max(progress.max_poses - progress.poses, 0));
  if (!interval) return nullptr;
  return {{"expected", interval->expected.count()},
          {"low", interval->low.count()},
          {"high", interval->high.count()}};
}

}  // namespace

void StatusFile::Enter(SessionState state) {
  state_ = state;
  Write();
  written_ = std::chrono::steady_clock::now();
}

void StatusFile::Show(const Progress& progress) {
  progress_ = progress;
  left_.Show(progress.poses, progress.elapsed);
  const auto now = std::chrono::steady_clock::now();
  if (now - written_ < kRefresh) return;
  written_ = now;
  Write();
}

void StatusFile::End(const SessionSummary& summary) {
  summary_ = &summary;
  Write();
  summary_ = nullptr;
}

void StatusFile::Write() const {
  json status = {{"state", ToString(state_)},
                 {"process", static_cast<long>(::getpid())},
                 {"updated_utc", UtcText(std::time(nullptr))}};
  if (progress_) {
    status["poses"] = progress_->poses;
    status["max_poses"] = progress_->max_poses;
    status["rejected"] = progress_->rejected;
    status["elapsed_s"] = progress_->elapsed.count();
    status["left_s"] = Left(left_, *progress_);
    status["predicted_error"] =
        progress_->predicted_error ? json(*progress_->predicted_error) : json();
  }
  if (summary_ != nullptr) {
    status["poses"] = summary_->poses.size();
    status["outcome"] = ToString(summary_->outcome);
    status["reason"] = summary_->reason;
  }
  try {
    WriteFileAtomically(path_, [&](std::ostream& out) { out << status.dump(2) << '\n'; });
  } catch (const std::runtime_error&) {
  }
}

}  // namespace gonio
