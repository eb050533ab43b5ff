// SPDX-License-Identifier: Apache-2.0
// One task of a frontier study: a contestant measures a material.

#pragma once

#include <optional>
#include <stop_token>

#include "apps/gonio/frontier_config.h"
#include "apps/gonio/frontier_folds.h"
#include "apps/gonio/frontier_result.h"

namespace gonio {

// The rig of a study without noise: every imperfection of the simulation is off, the camera counts
// in 16 bits, and the rig believes that it has no noise but photons'.
RigFile WithoutNoise(RigFile rig);

struct FrontierSession {
  const FrontierConfig& study;
  const RigFile& rig;  // as the noise wants it
  const FrontierMaterial& material;
  const Contestant& contestant;
  const Knowledge* learned = nullptr;  // null for a contestant that is not taught
  std::uint64_t seed = 1;
};

// Measures, reconstructs and scores: rows, stops and CPU times of `cell`. false: stopped by `now`.
// Throws ConfigError on what no contestant should do: score a material its prior has seen, a device
// fault, no pose at all; a reconstruction that fails is a row with a failure.
bool RunFrontierSession(const FrontierSession& session, const std::stop_token& now,
                        FrontierCell* cell);

}  // namespace gonio
