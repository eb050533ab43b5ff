// SPDX-License-Identifier: Apache-2.0
#include "acquisition/reference_visits.h"

#include <fmt/format.h>

#include <cmath>
#include <limits>
#include <utility>

#include "core/check.h"

namespace gonio {
namespace {

// The parts of one image are one patch: their mean, by how sure they are.
ReferenceVisit ReadingOf(Seconds time, const std::vector<ReducedSample>& parts) {
  ReferenceVisit read;
  read.time = time;
  for (int c = 0; c < kChannels; ++c) {
    double variance = 0;
    double n = 0;
    for (const ReducedSample& part : parts) {
      if (!std::isfinite(part.sample.sigma[c])) continue;
      read.signal[c] += part.sample.f_r[c];
      variance += part.sample.sigma[c] * part.sample.sigma[c];
      n += 1;
    }
    read.signal[c] = n > 0 ? read.signal[c] / n : 0;
    read.sigma[c] = n > 0 ? std::sqrt(variance) / n : std::numeric_limits<double>::infinity();
  }
  return read;
}

void SetRatio(const ReferenceVisit& first, ReferenceRecord* visit) {
  const ReferenceVisit& read = visit->read;
  visit->ratio = read.signal / first.signal;
  visit->ratio_sigma =
      (read.sigma.square() + (visit->ratio * first.sigma).square()).sqrt() / first.signal.abs();
}

}  // namespace

bool ReferenceVisits::Due(int poses, Seconds now) const {
  const DriftPolicy& policy = rig_.drift;
  if (!policy.on() || (!policy.pose && !first_)) return false;
  if (!last_) return true;
  return (policy.every_poses > 0 && poses - poses_then_ >= policy.every_poses) ||
         (policy.every > Seconds::zero() && now - *last_ >= policy.every);
}

Result<ReferenceRecord> ReferenceVisits::Visit(PoseMeasurer& measurer, int poses,
                                               std::stop_token stop) {
  GONIO_CHECK(rig_.drift.pose || first_, "a reference to visit");
  const DirectionPair there = rig_.drift.pose ? ToDirections(*rig_.drift.pose) : *first_;
  std::optional<Rgb> expected;
  if (first_read_) expected = first_read_->signal;
  auto measured = measurer.Measure(there, expected, std::move(stop), rig_.drift.frames);
  poses_then_ = poses;
  if (!measured) return measured.error();
  ReferenceRecord visit;
  visit.record = std::move(measured).value();
  last_ = visit.record.end;
  const auto reduced = Reduce(visit.record, rig_, calibrations_);
  if (!reduced) return reduced.error();
  visit.read = ReadingOf(visit.record.end, *reduced);
  if (!visit.read.sigma.isFinite().any()) {
    return Error{ErrorCode::kRefused, "no channel of the reference was measured"};
  }
  for (const Exposure& e : visit.record.exposures) {
    visit.net.push_back(
        MeansOf(e.frame, rig_.camera.full_scale, visit.record.regions, e.colour).counts);
  }
  if (!first_read_) first_read_ = visit.read;
  tracker_.Add(visit.read);
  visit.visit = tracker_.visits();
  visit.poses = poses;
  visit.gain = tracker_.At(visit.read.time);
  SetRatio(*first_read_, &visit);
  return visit;
}

void ReferenceVisits::Recall(const LoggedVisit& visit) {
  poses_then_ = visit.poses;
  if (!visit.read) return;
  last_ = visit.time;
  if (!first_read_) first_read_ = visit.read;
  tracker_.Add(*visit.read);
}

void ReferenceVisits::Correct(Seconds time, std::vector<ReducedSample>* samples) const {
  if (tracker_.visits() == 0) return;
  const Gain gain = tracker_.At(time);
  for (ReducedSample& one : *samples) {
    one.sample.f_r /= gain.value;
    one.sample.sigma /= gain.value;
    for (Rgb& term : one.budget.terms) term /= gain.value;
    one.budget[UncertaintyTerm::kDrift] = one.sample.f_r.abs() * gain.sigma / gain.value;
  }
}

std::string ReferenceVisits::Complaint(Seconds now) const {
  if (!rig_.drift.max_change || tracker_.visits() == 0) return {};
  const Gain gain = tracker_.At(now);
  for (int c = 0; c < kChannels; ++c) {
    const double change = gain.value[c] - 1;
    if (std::abs(change) <= *rig_.drift.max_change || std::abs(change) <= 2 * gain.sigma[c]) {
      continue;
    }
    return fmt::format(
        "{} of the reference has changed by {:.2f} +- {:.2f} % since the first of {} visits; "
        "drift.max_change_percent is {:.4g}",
        kChannelNames[c], 100 * change, 100 * gain.sigma[c], tracker_.visits(),
        100 * *rig_.drift.max_change);
  }
  return {};
}

}  // namespace gonio
