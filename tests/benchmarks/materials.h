// SPDX-License-Identifier: Apache-2.0
// What the benchmarks measure, and readings of it.

#pragma once

#include <stdlib.h>

#include <filesystem>
#include <memory>
#include <stdexcept>
#include <string>
#include <system_error>
#include <vector>

#include "brdf/analytic.h"
#include "brdf/brdf.h"
#include "planner/candidates.h"
#include "sim/random.h"

namespace gonio {

// The default sample of a simulated rig. It is no DSBRDF, so fits have something to work at.
inline const Brdf& SatinPaint() {
  static const std::unique_ptr<Brdf> brdf =
      LoadMaterial(GONIO_SOURCE_DIR "/configs/materials/satin-paint.yaml");
  return *brdf;
}

// A reading with 1.5 % noise.
inline BrdfSample Reading(const DirectionPair& pair, Random& random) {
  const Rgb f_r = *SatinPaint().Eval(pair);
  BrdfSample sample{.directions = pair, .f_r = f_r, .sigma = 0.015 * f_r + 1e-4};
  for (int c = 0; c < kChannels; ++c) sample.f_r[c] += sample.sigma[c] * random.Normal();
  return sample;
}

// One reading in each cell of the 90 x 90 raster: 8,100 poses, 24,300 numbers.
inline const std::vector<BrdfSample>& DenseReadings() {
  static const std::vector<BrdfSample> samples = [] {
    Random random(1, 0);
    std::vector<BrdfSample> readings;
    for (const Candidate& candidate : MakeCandidates({}, {})) {
      readings.push_back(Reading(candidate.directions, random));
    }
    return readings;
  }();
  return samples;
}

// A folder that is removed at the end.
class ScratchFolder {
 public:
  ScratchFolder() {
    std::string pattern = (std::filesystem::temp_directory_path() / "gonio-XXXXXX").string();
    if (::mkdtemp(pattern.data()) == nullptr) throw std::runtime_error("cannot make " + pattern);
    path_ = pattern;
  }
  ~ScratchFolder() {
    std::error_code ignored;
    std::filesystem::remove_all(path_, ignored);
  }
  ScratchFolder(const ScratchFolder&) = delete;
  ScratchFolder& operator=(const ScratchFolder&) = delete;

  std::filesystem::path operator/(const std::string& name) const { return path_ / name; }

 private:
  std::filesystem::path path_;
};

}  // namespace gonio
