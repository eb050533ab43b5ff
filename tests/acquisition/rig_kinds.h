// SPDX-License-Identifier: Apache-2.0
// Rigs of every kind, with solids whose gaps are found by points and by the simulator's geometry.

#pragma once

#include <algorithm>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "core/file.h"
#include "sim/random.h"
#include "tests/acquisition/simulated_rig.h"

namespace gonio {

struct KindOfRig {
  const char* file;  // in configs/
  RigKind kind;
  SimRigKind truth;
};
inline void PrintTo(const KindOfRig& kind, std::ostream* out) { *out << kind.file; }

inline const std::vector<KindOfRig> kEveryKind = {
    {"sim-rig.yaml", RigKind::kFourAxisArms, SimRigKind::kFourAxisArms},
    {"rig-turntable.yaml", RigKind::kTurntable, SimRigKind::kTurntable},
    {"rig-tilting-sample.yaml", RigKind::kTiltingSample, SimRigKind::kTiltingSample},
};

inline std::string NameOf(const testing::TestParamInfo<KindOfRig>& info) {
  std::string name(ToString(info.param.kind));
  std::erase(name, '-');
  return name;
}

inline std::string TextOf(const KindOfRig& kind) {
  return ReadTextFile(std::string(GONIO_SOURCE_DIR "/configs/") + kind.file);
}

inline RigConfig RigOf(const KindOfRig& kind) {
  const std::string text = TextOf(kind);
  return ReadRig(ConfigNode::Parse(text, kind.file), text);
}

inline AxisPositions RandomPositions(const RigConfig& rig, Random& random) {
  AxisPositions positions{};
  for (int i = 0; i < rig.axis_count; ++i) {
    const AxisLimits& axis = rig.axes[i];
    positions[i] = axis.min_position + random.Uniform() * (axis.max_position - axis.min_position);
  }
  return positions;
}

// Bars only, so that gaps are found by points: along the arms and beside them, across the sample
// where it turns, and one that stands still.
inline RigConfig RigOfBars(const KindOfRig& kind) {
  RigConfig rig = RigOf(kind);
  rig.keep_out = {};
  rig.keep_out.margin = 0.01;
  if (kind.kind != RigKind::kTiltingSample) {
    rig.keep_out.light_arm = {{.from = {0.2, 0, 0}, .to = {0.7, 0, 0}, .radius = 0.03}};
  }
  rig.keep_out.camera_arm = {
      {.from = {0.25, 0, 0}, .to = {0.6, 0, 0}, .radius = 0.03},
      {.from = {0.3, -0.06, -0.02}, .to = {0.5, -0.1, 0.05}, .radius = 0.01}};
  rig.keep_out.fixed = {{.from = {0.1, -0.5, -0.1}, .to = {0.25, 0.5, -0.15}, .radius = 0.03}};
  if (kind.kind != RigKind::kFourAxisArms) {
    rig.keep_out.sample = {{.from = {-0.27, 0, 0.02}, .to = {0.2, 0.05, 0.02}, .radius = 0.02}};
  }
  return rig;
}

// A bar's axis in the sample's frame.
struct Bar {
  Eigen::Vector3d from;
  Eigen::Vector3d to;
  double radius = 0;
};

inline double DistanceTo(const Bar& bar, const Eigen::Vector3d& point) {
  const Eigen::Vector3d way = bar.to - bar.from;
  const double t = std::clamp((point - bar.from).dot(way) / way.squaredNorm(), 0.0, 1.0);
  return (bar.from + t * way - point).norm();
}

// m; up to 2 mm too large.
inline double SampledGap(const Bar& a, const Bar& b) {
  constexpr int kPoints = 64;
  double gap = std::numeric_limits<double>::infinity();
  for (int i = 0; i <= kPoints; ++i) {
    gap = std::min(gap, DistanceTo(b, a.from + (a.to - a.from) * i / kPoints));
  }
  return gap - a.radius - b.radius;
}

// The narrowest of a rig of bars, at true positions.
inline double SampledGap(const RigConfig& rig, SimRigKind truth, const AxisPositions& positions) {
  const SimPlacement place = Place(truth, positions);
  const auto on_arm = [](const SimMount& arm) {
    return [&arm](const Eigen::Vector3d& p) -> Eigen::Vector3d {
      return p.x() * arm.outward + p.y() * arm.right - p.z() * arm.down;
    };
  };
  const auto bars = [](const std::vector<SolidPart>& parts, const auto& in_sample) {
    std::vector<Bar> list;
    for (const SolidPart& part : parts) {
      list.push_back({in_sample(part.from), in_sample(part.to), part.radius});
    }
    return list;
  };
  const std::vector<std::vector<Bar>> bodies = {
      bars(rig.keep_out.light_arm, on_arm(place.light)),
      bars(rig.keep_out.camera_arm, on_arm(place.camera)),
      bars(rig.keep_out.sample, [](const Eigen::Vector3d& p) { return p; }),
      bars(rig.keep_out.fixed, [&](const Eigen::Vector3d& p) -> Eigen::Vector3d {
        return place.sample_from_machine * p;
      })};
  double gap = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    for (std::size_t j = i + 1; j < bodies.size(); ++j) {
      for (const Bar& a : bodies[i]) {
        for (const Bar& b : bodies[j]) gap = std::min(gap, SampledGap(a, b));
      }
    }
  }
  return gap;
}

}  // namespace gonio
