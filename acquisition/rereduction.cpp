// SPDX-License-Identifier: Apache-2.0
#include "acquisition/rereduction.h"

#include <fmt/format.h>

#include <utility>

#include "acquisition/measure.h"

namespace gonio {

Rereduction::Rereduction(const std::filesystem::path& session, const RigConfig& rig,
                         const Calibrations& calibrations, std::vector<LoggedVisit> visits)
    : rig_(rig),
      calibrations_(calibrations),
      visits_(std::move(visits)),
      kinematics_(rig),
      frames_(session) {}

PoseRecord Rereduction::RecordOf(const MeasuredPose& pose) {
  const SiteMask* const bad = calibrations_.bad_pixels ? &calibrations_.bad_pixels->mask : nullptr;
  return {.commanded = pose.commanded,
          .readback = pose.readback,
          .move_retries = pose.move_retries,
          .start = pose.start,
          .move_time = pose.move_time,
          .end = pose.end,
          .regions = RegionsSeen(rig_, kinematics_, pose.readback, bad),
          .exposures = frames_.Of(pose.pose)};
}

Result<std::vector<ReducedSample>> Rereduction::Of(const MeasuredPose& pose) {
  const PoseRecord record = RecordOf(pose);
  if (record.regions.empty() || record.exposures.empty()) {
    return Error{ErrorCode::kRefused, fmt::format("pose {}: no frame shows the sample", pose.pose)};
  }
  auto reduced = Reduce(record, rig_, calibrations_);
  if (!reduced) return reduced;
  ReferenceVisits references(rig_, calibrations_);
  for (const LoggedVisit& visit : visits_) {
    if (visit.poses < pose.pose) references.Recall(visit);
  }
  references.Correct(pose.end, &*reduced);
  return reduced;
}

}  // namespace gonio
