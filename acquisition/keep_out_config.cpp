// SPDX-License-Identifier: Apache-2.0
#include "acquisition/keep_out_config.h"

#include <algorithm>
#include <string>

#include "core/units.h"

namespace gonio {
namespace {

Eigen::Vector3d ReadPoint(const ConfigNode& node, const char* key) {
  const std::vector<double> mm = node.Numbers(key, 3, Range::Between(-1e5, 1e5));
  return Eigen::Vector3d(mm[0], mm[1], mm[2]) / 1000;
}

// What a part may say it turns with: the axes that carry it, from the base. One: it has no choice.
using Carriers = std::vector<std::string>;

Carriers CarriersOfArms(RigKind kind) {
  return kind == RigKind::kFourAxisArms ? Carriers{"azimuth", "elevation"} : Carriers{"arm"};
}

SolidPart ReadPart(const ConfigNode& node, const Carriers& carriers) {
  SolidPart part;
  if (node.Has("box_from_mm")) {
    part.shape = SolidPart::Shape::kBox;
    part.from = ReadPoint(node, "box_from_mm");
    part.to = ReadPoint(node, "box_to_mm");
    if ((part.to.array() <= part.from.array()).any()) {
      node.Fail("box_to_mm", "must be > box_from_mm in each coordinate");
    }
  } else {
    part.from = ReadPoint(node, "capsule_from_mm");
    part.to = ReadPoint(node, "capsule_to_mm");
    part.radius = node.Number("radius_mm", Range::Positive()) / 1000;
    if ((part.to - part.from).norm() < 1e-6) {
      node.Fail("capsule_to_mm", "is capsule_from_mm; of a ball, let them differ by 0.01 mm");
    }
  }
  if (carriers.size() > 1 && node.Has("turns_with")) {
    const std::string with = node.Choice("turns_with", carriers);
    part.axes =
        static_cast<int>(std::find(carriers.begin(), carriers.end(), with) - carriers.begin()) + 1;
  }
  return part;
}

std::vector<SolidPart> ReadParts(const ConfigNode& node, const char* key,
                                 const Carriers& carriers) {
  std::vector<SolidPart> parts;
  if (!node.Has(key)) return parts;
  for (const ConfigNode& part : node.MapList(key)) parts.push_back(ReadPart(part, carriers));
  return parts;
}

// The stages under a tilting sample, from the base.
Carriers CarriersOfSample(RigKind kind) {
  return kind == RigKind::kTiltingSample ? Carriers{"turn", "tilt", "azimuth"} : Carriers{};
}

}  // namespace

KeepOutConfig ReadKeepOut(const ConfigNode& node, RigKind kind) {
  KeepOutConfig config;
  config.margin = node.Number("margin_mm", Range::NonNegative()) / 1000;
  if (kind == RigKind::kTiltingSample && node.Has("light_arm")) {
    node.Fail("light_arm",
              "the light of a rig of kind tilting-sample stands still: put it under fixed");
  }
  config.light_arm = ReadParts(node, "light_arm", CarriersOfArms(kind));
  config.camera_arm = ReadParts(node, "camera_arm", CarriersOfArms(kind));
  config.fixed = ReadParts(node, "fixed", {});
  if (kind == RigKind::kFourAxisArms) {
    if (node.Has("sample")) {
      node.Fail("sample", "the sample of a rig of four-axis-arms stands still: put it under fixed");
    }
    if (node.Has("max_azimuth_difference_deg")) {
      config.max_azimuth_difference =
          RadFromDeg(node.Number("max_azimuth_difference_deg", Range::Between(1, 720)));
    }
    return config;
  }
  if (node.Has("max_azimuth_difference_deg")) {
    node.Fail("max_azimuth_difference_deg",
              "arms without azimuths wind no cables; those of the sample are kept by min_deg and "
              "max_deg of its axes");
  }
  config.sample = ReadParts(node, "sample", CarriersOfSample(kind));
  return config;
}

}  // namespace gonio
