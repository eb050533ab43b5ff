// SPDX-License-Identifier: Apache-2.0
// The last pose, measured again after an interruption: is all as it was?

#include <fmt/format.h>

#include <cmath>
#include <limits>

#include "acquisition/radiometry.h"
#include "acquisition/session_loop.h"

namespace gonio {
namespace {

// Numbers of draws beyond those of any pose.
constexpr std::uint64_t kReferenceDraws = std::uint64_t{1} << 32;

// By the channel that is known best.
ReferenceNote Compared(int pose, const BrdfSample& before, const BrdfSample& now) {
  ReferenceNote note{.pose = pose, .before = before, .now = now};
  double best = std::numeric_limits<double>::infinity();
  for (int c = 0; c < kChannels; ++c) {
    const double sigma = std::hypot(before.sigma[c], now.sigma[c]) / std::abs(before.f_r[c]);
    if (!(sigma < best)) continue;
    best = sigma;
    note.change = now.f_r[c] / before.f_r[c] - 1;
    note.sigma_change = sigma;
  }
  return note;
}

// What was possible before and is refused now is no matter of this pose.
template <typename T>
Result<T> NotRefused(Result<T> result, const std::string& what) {
  if (result.ok() || result.error().code != ErrorCode::kRefused) return result;
  return Error{ErrorCode::kProtocol, what + ": " + result.error().message};
}

}  // namespace

// After a resume: measures the last pose again, compares, and puts everything as it was then.
bool SessionLoop::GoBack() {
  if (parts_.so_far == nullptr) return true;
  if (parts_.so_far->reference) {
    const auto note = ReadReference(*parts_.so_far->reference);
    if (!note) return EndWith(note.error());
    if (!Accept(*note)) return false;
  }
  if (!parts_.so_far->measurer) return true;
  const auto restored = PutBack(*parts_.so_far->measurer);
  return restored.ok() || EndWith(restored.error());
}

Result<std::optional<ReferenceNote>> SessionLoop::LookBack(const MeasurerState& before) {
  std::optional<ReferenceNote> reference;
  if (last_) {
    auto read = ReadReference(*last_);
    if (!read) return read.error();
    reference = *read;
  }
  if (auto restored = PutBack(before); !restored) return restored.error();
  return reference;
}

Result<void> SessionLoop::PutBack(const MeasurerState& before) {
  const SessionAbort abort(stop_.now, parts_.interlocks);
  return NotRefused(measurer_.Restore(before, abort.token()), "back to where the arms were");
}

Result<ReferenceNote> SessionLoop::ReadReference(const SessionSoFar::Reference& reference) {
  Draw(kReferenceDraws + turn_);
  const SessionAbort abort(stop_.now, parts_.interlocks);
  const auto record = NotRefused(
      measurer_.MeasureAt(reference.arms, reference.before.f_r, abort.token(), reference.frames),
      fmt::format("pose {} once more", reference.pose));
  if (!record) return record.error();
  auto reduced = Reduce(*record, parts_.rig, calibrations_);
  if (!reduced) return reduced.error();
  references_.Correct(record->end, &*reduced);
  return Compared(reference.pose, reference.before, reduced->front().sample);
}

bool SessionLoop::Accept(const ReferenceNote& note) {
  if (!Kept([&](EventLog& log) { return log.AppendResumeReference(parts_.clock.Now(), note); })) {
    return false;
  }
  const double change = std::abs(note.change);
  if (!(change > options_.max_reference_change && change > 4 * note.sigma_change)) return true;
  return EndWith({ErrorCode::kProtocol,
                  fmt::format("pose {} reads {:+.1f} % ({:.1f} % standard uncertainty) against "
                              "before the interruption: something has changed",
                              note.pose, 100 * note.change, 100 * note.sigma_change)});
}

}  // namespace gonio
