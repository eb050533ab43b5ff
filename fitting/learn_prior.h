// SPDX-License-Identifier: Apache-2.0
// A prior from materials that were measured densely.

#pragma once

#include <span>
#include <string>

#include "fitting/prior.h"
#include "fitting/process_learning.h"
#include "fitting/training.h"

namespace gonio {

struct LearnOptions {
  std::string name = "learned";
  ProcessBasis basis;
  double floor = 0.02;            // 1/sr, > 0: of the process's glog
  int luminance_components = 32;  // > 0: at most
  int chroma_components = 20;     // > 0: at most
  ReadingRaster raster;           // where the materials are read
  DsbrdfShape shape;              // of the lobes
  bool lobes = true;              // learn their parameters, too; else the generic prior's
  int threads = 1;                // >= 1

  // Throws ConfigError naming the option.
  void Check() const;
};

// Learns the process over the whole reflectance (fitting/process_prior.h): mean, principal
// components, spread of the stationary part; and a prior of the lobes' parameters
// (fitting/lobe_learning.h) for those who fit a DSBRDF.
//
// Throws ConfigError: fewer than kLeastMaterials, two of the same name, a material that knows less
// than half of the directions. Deterministic, whatever the number of threads. About 0.5 s a
// material.
inline constexpr int kLeastMaterials = 3;
Prior LearnPrior(std::span<const TrainingMaterial> materials, const LearnOptions& options = {});

}  // namespace gonio
