// SPDX-License-Identifier: Apache-2.0
#include "acquisition/keep_out.h"

#include <fcl/geometry/shape/box.h>
#include <fcl/geometry/shape/capsule.h>
#include <fcl/narrowphase/distance.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "core/units.h"

namespace gonio {
namespace {

using Pose = Eigen::Isometry3d;

constexpr double kFinest = 0.25 * kPi / 180;  // rad: pieces of a box are not made smaller
// A box with so many pieces is a way along a wall: it counts as blocked.
constexpr int kMostPieces = 200000;

// A solid with its place in the frame of what it is mounted on.
struct Solid {
  std::string name;
  std::shared_ptr<fcl::CollisionGeometryd> geometry;
  Pose place = Pose::Identity();
  double reach = 0;  // m: no point of its core is further from the origin
  bool tilts = false;
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

std::vector<Solid> MakeSolids(const std::vector<SolidPart>& parts, const char* owner) {
  std::vector<Solid> solids;
  for (const SolidPart& part : parts) {
    solids.push_back(part.shape == SolidPart::Shape::kCapsule ? MakeCapsule(part) : MakeBox(part));
    solids.back().name = fmt::format("{} {}", owner, solids.size());
    solids.back().tilts = part.tilts;
  }
  return solids;
}

// Where the frame of an arm is: its x away from the sample along the arm, its z towards growing
// elevation. A part that does not tilt stays at elevation 0.
Pose Mount(const Solid& solid, double azimuth, double elevation) {
  Pose pose = Pose::Identity();
  pose.rotate(Eigen::AngleAxisd(azimuth, Eigen::Vector3d::UnitZ()));
  if (solid.tilts) pose.rotate(Eigen::AngleAxisd(-elevation, Eigen::Vector3d::UnitY()));
  return pose * solid.place;
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

// Two solids, and how their gap depends on at most three angles. Turning both arms together changes
// nothing between them, so of two azimuths only the difference counts.
class Pair {
 public:
  // An arm and what does not move.
  Pair(const Solid& arm, int azimuth, const Solid& fixed)
      : first_(arm), second_(fixed), azimuth_(azimuth), elevations_{azimuth + 1, -1} {}
  Pair(const Solid& light, const Solid& camera)
      : first_(light), second_(camera), elevations_{kLightElevation, kCameraElevation} {}

  // The first piece of the box that is not at least `margin` wide open.
  std::optional<Contact> Find(const ArmAngles& low, const ArmAngles& high, double margin) const {
    std::vector<Piece> pieces = {Whole(low, high)};
    for (int count = 0; !pieces.empty(); ++count) {
      const Piece piece = pieces.back();
      pieces.pop_back();
      const double gap = GapAt(piece);
      const Piece change = ChangeIn(piece);
      if (gap - margin > change[0].high + change[1].high + change[2].high) continue;
      const std::size_t widest = Widest(change);
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
  // Azimuth (of camera against light, if both move), elevation of the first, of the second.
  using Piece = std::array<Span, 3>;

  bool both_move() const { return elevations_[1] >= 0; }

  Piece Whole(const ArmAngles& low, const ArmAngles& high) const {
    Piece piece;
    piece[0] = both_move() ? Span{low[kCameraAzimuth] - high[kLightAzimuth],
                                  high[kCameraAzimuth] - low[kLightAzimuth]}
                           : Span{low[azimuth_], high[azimuth_]};
    piece[0].high = std::min(piece[0].high, piece[0].low + 2 * kPi);
    piece[1] = {low[elevations_[0]], high[elevations_[0]]};
    if (both_move()) piece[2] = {low[elevations_[1]], high[elevations_[1]]};
    return piece;
  }

  double GapAt(const Piece& piece) const {
    const double azimuth = piece[0].middle();
    const double second = piece[2].middle();
    if (!both_move()) {
      return Gap(first_, Mount(first_, azimuth, piece[1].middle()), second_, second_.place);
    }
    return Gap(first_, Mount(first_, 0, piece[1].middle()), second_,
               Mount(second_, azimuth, second));
  }

  // By how much [m] each angle may change the gap at most, as Span::high.
  Piece ChangeIn(const Piece& piece) const {
    const double turned = both_move() ? std::min(first_.reach, second_.reach) : first_.reach;
    const double tilted = first_.tilts ? first_.reach : 0;
    const double also_tilted = both_move() && second_.tilts ? second_.reach : 0;
    return {Span{0, turned * piece[0].half()}, Span{0, tilted * piece[1].half()},
            Span{0, also_tilted * piece[2].half()}};
  }

  static std::size_t Widest(const Piece& change) {
    const auto less = [](const Span& a, const Span& b) { return a.high < b.high; };
    return std::max_element(change.begin(), change.end(), less) - change.begin();
  }

  Contact At(const Piece& piece, double gap, const ArmAngles& low) const {
    Contact contact{.first = first_.name, .second = second_.name, .at = low, .gap = gap};
    contact.at[elevations_[0]] = piece[1].middle();
    if (both_move()) {
      contact.at[elevations_[1]] = piece[2].middle();
      contact.at[kCameraAzimuth] = low[kLightAzimuth] + piece[0].middle();
    } else {
      contact.at[azimuth_] = piece[0].middle();
    }
    return contact;
  }

  const Solid& first_;
  const Solid& second_;
  int azimuth_ = kLightAzimuth;  // of the arm, if only one moves
  std::array<int, 2> elevations_;
};

}  // namespace

std::string Contact::Text() const {
  std::string where;
  for (int i = 0; i < kAxes; ++i) {
    where += fmt::format("{}{} {:.1f}", i == 0 ? "" : ", ", kAxisNames[i], DegFromRad(at[i]));
  }
  if (second.empty()) return fmt::format("the cables do not reach to {} deg", where);
  return fmt::format("{} and {} come within {:.1f} mm of each other at {} deg", first, second,
                     1000 * gap, where);
}

struct KeepOut::Impl {
  explicit Impl(const KeepOutConfig& config)
      : margin(config.margin),
        cables(config.max_azimuth_difference),
        light(MakeSolids(config.light_arm, "light_arm")),
        camera(MakeSolids(config.camera_arm, "camera_arm")),
        fixed(MakeSolids(config.fixed, "fixed")) {
    for (const Solid& a : light) {
      for (const Solid& b : camera) pairs.emplace_back(a, b);
    }
    for (const Solid& still : fixed) {
      for (const Solid& arm : light) pairs.emplace_back(arm, kLightAzimuth, still);
      for (const Solid& arm : camera) pairs.emplace_back(arm, kCameraAzimuth, still);
    }
  }

  double margin;
  std::optional<double> cables;
  std::vector<Solid> light, camera, fixed;
  std::vector<Pair> pairs;  // refer to the solids
};

KeepOut::KeepOut(const RigConfig& rig) : impl_(std::make_unique<Impl>(rig.keep_out)) {}
KeepOut::~KeepOut() = default;
KeepOut::KeepOut(KeepOut&&) noexcept = default;
KeepOut& KeepOut::operator=(KeepOut&&) noexcept = default;

bool KeepOut::empty() const { return impl_->pairs.empty() && !impl_->cables; }

std::optional<Contact> KeepOut::FindAt(const ArmAngles& angles) const {
  return FindBetween(angles, angles);
}

std::optional<Contact> KeepOut::FindBetween(const ArmAngles& low, const ArmAngles& high) const {
  if (impl_->cables) {
    const double most = std::max(high[kCameraAzimuth] - low[kLightAzimuth],
                                 high[kLightAzimuth] - low[kCameraAzimuth]);
    if (most > *impl_->cables + 1e-9)
      return Contact{.first = "cables", .second = "", .at = high, .gap = 0};
  }
  for (const Pair& pair : impl_->pairs) {
    if (auto contact = pair.Find(low, high, impl_->margin)) return contact;
  }
  return std::nullopt;
}

}  // namespace gonio
