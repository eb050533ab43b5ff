// SPDX-License-Identifier: Apache-2.0
// A process learned from a handful of analytic paints: small enough to learn in every test.

#pragma once

#include <memory>
#include <string>
#include <vector>

#include "brdf/analytic.h"
#include "fitting/learn_prior.h"

namespace gonio {

// A paint of this roughness and brightness; red, green and blue differ.
inline AnalyticBrdf PaintOf(double roughness, double albedo) {
  return AnalyticBrdf("paint", {Lambert{{albedo, 0.8 * albedo, 0.5 * albedo}},
                                Ggx{.roughness = roughness, .ior = 1.5}});
}

inline LearnOptions SmallLearnOptions() {
  LearnOptions options;
  options.basis = ProcessBasis(12, 6);
  options.raster = {.theta_h = 36, .theta_d = 15, .phi_d = 5};
  options.luminance_components = 8;
  options.chroma_components = 4;
  return options;
}

// Learned from nine paints of roughness 0.15 .. 0.5 and albedo 0.1 .. 0.6, once for each program.
inline const Prior& SmallProcessPrior() {
  static const Prior learned = [] {
    std::vector<std::unique_ptr<AnalyticBrdf>> paints;
    std::vector<TrainingMaterial> materials;
    for (const double roughness : {0.15, 0.3, 0.5}) {
      for (const double albedo : {0.1, 0.3, 0.6}) {
        paints.push_back(std::make_unique<AnalyticBrdf>(PaintOf(roughness, albedo)));
        materials.push_back({"paint" + std::to_string(paints.size()), paints.back().get()});
      }
    }
    return LearnPrior(materials, SmallLearnOptions());
  }();
  return learned;
}

}  // namespace gonio
