// SPDX-License-Identifier: Apache-2.0
#include "acquisition/keep_out.h"

#include <fcl/geometry/shape/box.h>
#include <fcl/geometry/shape/capsule.h>
#include <fcl/narrowphase/distance.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "acquisition/sample_orientation.h"
#include "core/units.h"

namespace gonio {
namespace {

using Pose = Eigen::Isometry3d;

constexpr double kFinest = 0.25 * kPi / 180;  // rad: pieces of a box are not made smaller
// A box with so many pieces is a way along a wall: it counts as blocked.
constexpr int kMostPieces = 200000;

// One axis of the machine, through the origin: it turns what it carries about `about`, which is
// given as it stands while all axes are at 0.
struct Turn {
  int axis = 0;
  Eigen::Vector3d about = Eigen::Vector3d::UnitZ();
};

// What carries a solid: axes from the base outwards. None: it does not move.
using Mount = std::vector<Turn>;

// Along an arm's own y downwards: elevations grow towards z.
const Eigen::Vector3d kTilt = -Eigen::Vector3d::UnitY();

struct Mounts {
  Mount light, camera, sample;
  Pose sample_at_zero = Pose::Identity();  // its frame in the machine's
};

Mounts MountsOf(RigKind kind) {
  const Eigen::Vector3d up = Eigen::Vector3d::UnitZ();
  switch (kind) {
    case RigKind::kFourAxisArms:
      return {.light = {{kLightAzimuth, up}, {kLightElevation, kTilt}},
              .camera = {{kCameraAzimuth, up}, {kCameraElevation, kTilt}},
              .sample = {}};
    case RigKind::kTurntable:
      return {.light = {{turntable::kLightArm, kTilt}},
              .camera = {{turntable::kCameraArm, kTilt}},
              .sample = {{turntable::kSampleTurn, up}}};
    case RigKind::kTiltingSample:
      return {.light = {},
              .camera = {{tilting_sample::kCameraArm, up}},
              .sample = {{tilting_sample::kSampleTurn, up},
                         {tilting_sample::kSampleTilt, kTilt},
                         {tilting_sample::kSampleAzimuth, Eigen::Vector3d::UnitX()}},
              .sample_at_zero = Pose(SampleAtZero())};
  }
  return {};
}

// A solid with its place in the frame of what it is mounted on.
struct Solid {
  std::string name;
  std::shared_ptr<fcl::CollisionGeometryd> geometry;
  Pose place = Pose::Identity();
  double reach = 0;  // m: no point of its core is further from the origin
  Mount mount;
};

// FCL's capsule stands along its own z, its middle in the origin.
Solid MakeCapsule(const SolidPart& part) {
  const Eigen::Vector3d way = part.to - part.from;
  Solid solid;
  solid.geometry = std::make_shared<fcl::Capsuled>(part.radius, way.norm());
  solid.place.translation() = (part.from + part.to) / 2;
  solid.place.linear() =
      Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitZ(), way).toRotationMatrix();
  solid.reach = std::max(part.from.norm(), part.to.norm());
  return solid;
}

Solid MakeBox(const SolidPart& part) {
  const Eigen::Vector3d size = part.to - part.from;
  Solid solid;
  solid.geometry = std::make_shared<fcl::Boxd>(size);
  solid.place.translation() = (part.from + part.to) / 2;
  solid.reach = part.from.cwiseAbs().cwiseMax(part.to.cwiseAbs()).norm();
  return solid;
}

std::vector<Solid> MakeSolids(const std::vector<SolidPart>& parts, const char* owner,
                              const Mount& mount) {
  std::vector<Solid> solids;
  for (const SolidPart& part : parts) {
    solids.push_back(part.shape == SolidPart::Shape::kCapsule ? MakeCapsule(part) : MakeBox(part));
    solids.back().name = fmt::format("{} {}", owner, solids.size());
    const auto carried = std::min(mount.size(), static_cast<std::size_t>(part.axes));
    solids.back().mount.assign(mount.begin(), mount.begin() + static_cast<std::ptrdiff_t>(carried));
  }
  return solids;
}

double Gap(const Solid& a, const Pose& at_a, const Solid& b, const Pose& at_b) {
  const fcl::DistanceRequestd request;
  fcl::DistanceResultd result;
  return std::max(0.0,
                  fcl::distance(a.geometry.get(), at_a, b.geometry.get(), at_b, request, result));
}

// An interval of one angle.
struct Span {
  double low = 0;
  double high = 0;
  double middle() const { return (low + high) / 2; }
  double half() const { return (high - low) / 2; }
};

// One angle that a gap depends on: the position of an axis, or of one less that of another where
// both turn about the same line. Turning both then changes nothing, so only the difference counts.
struct Angle {
  int axis = 0;
  int less = -1;     // none
  double reach = 0;  // m of gap per radian, at most

  Span Between(const AxisPositions& low, const AxisPositions& high) const {
    Span span{low[axis], high[axis]};
    if (less >= 0) span = {low[axis] - high[less], high[axis] - low[less]};
    span.high = std::min(span.high, span.low + 2 * kPi);
    return span;
  }
};

// Two solids of which at least one moves.
class Pair {
 public:
  Pair(const Solid& first, const Solid& second) : first_(first), second_(second) {
    const bool together = !first.mount.empty() && !second.mount.empty() &&
                          first.mount[0].about == second.mount[0].about;
    if (together) {
      angles_.push_back(
          {second.mount[0].axis, first.mount[0].axis, std::min(first.reach, second.reach)});
      second_angles_.push_back(0);
      skipped_ = 1;
    }
    for (std::size_t i = skipped_; i < first.mount.size(); ++i) {
      first_angles_.push_back(angles_.size());
      angles_.push_back({first.mount[i].axis, -1, first.reach});
    }
    for (std::size_t i = skipped_; i < second.mount.size(); ++i) {
      second_angles_.push_back(angles_.size());
      angles_.push_back({second.mount[i].axis, -1, second.reach});
    }
  }

  // The first piece of the box that is not at least `margin` wide open.
  std::optional<Contact> Find(const AxisPositions& low, const AxisPositions& high,
                              double margin) const {
    std::vector<Piece> pieces = {Whole(low, high)};
    for (int count = 0; !pieces.empty(); ++count) {
      const Piece piece = pieces.back();
      pieces.pop_back();
      const double gap = GapAt(piece);
      const Changes changes = ChangesIn(piece);
      if (gap - margin > std::accumulate(changes.begin(), changes.end(), 0.0)) continue;
      const std::size_t widest = std::max_element(changes.begin(), changes.end()) - changes.begin();
      const bool finest = piece[widest].high - piece[widest].low <= kFinest;
      if (gap <= margin || finest || count > kMostPieces) return At(piece, gap, low);
      Piece half = piece;
      half[widest].high = piece[widest].middle();
      pieces.push_back(half);
      half[widest] = {piece[widest].middle(), piece[widest].high};
      pieces.push_back(half);
    }
    return std::nullopt;
  }

 private:
  static constexpr std::size_t kMostAngles = 4;
  using Piece = std::array<Span, kMostAngles>;
  using Changes = std::array<double, kMostAngles>;

  Piece Whole(const AxisPositions& low, const AxisPositions& high) const {
    Piece piece;
    for (std::size_t k = 0; k < angles_.size(); ++k) piece[k] = angles_[k].Between(low, high);
    return piece;
  }

  double GapAt(const Piece& piece) const {
    const Pose first = Turned(first_.mount, skipped_, first_angles_, piece) * first_.place;
    const Pose second = Turned(second_.mount, 0, second_angles_, piece) * second_.place;
    return Gap(first_, first, second_, second);
  }

  // By the axes of the mount from `begin` on.
  static Pose Turned(const Mount& mount, std::size_t begin, const std::vector<std::size_t>& angles,
                     const Piece& piece) {
    Pose pose = Pose::Identity();
    for (std::size_t i = begin; i < mount.size(); ++i) {
      pose.rotate(Eigen::AngleAxisd(piece[angles[i - begin]].middle(), mount[i].about));
    }
    return pose;
  }

  // By how much [m] each angle may change the gap at most.
  Changes ChangesIn(const Piece& piece) const {
    Changes changes{};
    for (std::size_t k = 0; k < angles_.size(); ++k) {
      changes[k] = angles_[k].reach * piece[k].half();
    }
    return changes;
  }

  Contact At(const Piece& piece, double gap, const AxisPositions& low) const {
    Contact contact{.first = first_.name, .second = second_.name, .at = low, .gap = gap};
    for (std::size_t k = 0; k < angles_.size(); ++k) {
      const Angle& angle = angles_[k];
      contact.at[angle.axis] = piece[k].middle() + (angle.less >= 0 ? low[angle.less] : 0);
    }
    return contact;
  }

  const Solid& first_;
  const Solid& second_;
  std::vector<Angle> angles_;
  std::size_t skipped_ = 0;  // of the first's turns, which are in the second's
  std::vector<std::size_t> first_angles_, second_angles_;  // indices, one for each turn
};

}  // namespace

std::string Contact::Text() const {
  std::string where;
  for (std::size_t i = 0; i < axes.size(); ++i) {
    where += fmt::format("{}{} {:.1f}", i == 0 ? "" : ", ", axes[i], DegFromRad(at[i]));
  }
  if (second.empty()) return fmt::format("the cables do not reach to {} deg", where);
  return fmt::format("{} and {} come within {:.1f} mm of each other at {} deg", first, second,
                     1000 * gap, where);
}

struct KeepOut::Impl {
  explicit Impl(const RigConfig& rig)
      : axes(rig.axis_names()),
        margin(rig.keep_out.margin),
        cables(rig.keep_out.max_azimuth_difference) {
    const KeepOutConfig& config = rig.keep_out;
    const Mounts mounts = MountsOf(rig.geometry.kind);
    light = MakeSolids(config.light_arm, "light_arm", mounts.light);
    camera = MakeSolids(config.camera_arm, "camera_arm", mounts.camera);
    sample = MakeSolids(config.sample, "sample", mounts.sample);
    for (Solid& solid : sample) solid.place = mounts.sample_at_zero * solid.place;
    fixed = MakeSolids(config.fixed, "fixed", {});
    PairUp(light, camera);
    for (const Solid& still : fixed) {
      PairUp(light, still);
      PairUp(camera, still);
      PairUp(sample, still);
    }
    for (const Solid& turning : sample) {
      PairUp(light, turning);
      PairUp(camera, turning);
    }
  }

  void PairUp(const std::vector<Solid>& some, const std::vector<Solid>& others) {
    for (const Solid& one : some) {
      for (const Solid& other : others) pairs.emplace_back(one, other);
    }
  }
  void PairUp(const std::vector<Solid>& some, const Solid& other) {
    for (const Solid& one : some) pairs.emplace_back(one, other);
  }

  std::span<const char* const> axes;
  double margin;
  std::optional<double> cables;
  std::vector<Solid> light, camera, sample, fixed;
  std::vector<Pair> pairs;  // refer to the solids
};

KeepOut::KeepOut(const RigConfig& rig) : impl_(std::make_unique<Impl>(rig)) {}
KeepOut::~KeepOut() = default;
KeepOut::KeepOut(KeepOut&&) noexcept = default;
KeepOut& KeepOut::operator=(KeepOut&&) noexcept = default;

bool KeepOut::empty() const { return impl_->pairs.empty() && !impl_->cables; }

std::optional<Contact> KeepOut::FindAt(const AxisPositions& positions) const {
  return FindBetween(positions, positions);
}

std::optional<Contact> KeepOut::FindBetween(const AxisPositions& low,
                                            const AxisPositions& high) const {
  std::optional<Contact> contact;
  if (impl_->cables) {
    const double most = std::max(high[kCameraAzimuth] - low[kLightAzimuth],
                                 high[kLightAzimuth] - low[kCameraAzimuth]);
    if (most > *impl_->cables + 1e-9) contact = Contact{.first = "cables", .at = high};
  }
  for (const Pair& pair : impl_->pairs) {
    if (contact) break;
    contact = pair.Find(low, high, impl_->margin);
  }
  if (contact) contact->axes = impl_->axes;
  return contact;
}

}  // namespace gonio
