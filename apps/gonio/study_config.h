// SPDX-License-Identifier: Apache-2.0
// A study file: which materials, thinned and fitted how.

#pragma once

#include <array>
#include <filesystem>
#include <string>
#include <vector>

#include "brdf/brdf.h"
#include "fitting/table_fit.h"

namespace gonio {

// Renders of some materials, refitted at some densities, beside each other.
struct StudyMontage {
  std::vector<std::string> materials;  // names; those the study does not have are left out
  std::vector<int> keep_every;
  FitMethod method = FitMethod::kJoint;
  std::vector<std::string> lights;  // "point", "env"
};

struct StudyConfig {
  std::string name;
  std::vector<std::string> materials;  // file names or patterns such as "*.binary"
  std::vector<FitMethod> methods;
  std::vector<int> keep_every;
  std::array<bool, kChannels> colours = {true, true, true};
  int lobes = 3;
  double slice_step = RadFromDeg(5);  // rad
  int phi_stride = 1;                 // of the metrics
  StudyMontage montage;               // none if it has no materials
};

// `kind: thinning` (the default) or `frontier` (apps/gonio/frontier_config.h).
enum class StudyKind { kThinning, kFrontier };
// Throws ConfigError.
StudyKind KindOfStudy(const std::filesystem::path& path);

// docs/data-format.md describes the file. Throws ConfigError.
StudyConfig LoadStudy(const std::filesystem::path& path);

// The files that the names and patterns under `key` stand for, in its order, each once. They are
// looked for in `folders`, or, if there are none, beside the study file and among the materials
// that gonio comes with. Throws ConfigError on a name without wildcards that is not there, and on
// two different files that would be confused in the results as they have the same stem.
std::vector<std::filesystem::path> FindFiles(const std::vector<std::string>& patterns,
                                             const std::string& key,
                                             const std::filesystem::path& study_file,
                                             const std::vector<std::filesystem::path>& folders);
// FindFiles() for the key `materials`, of which there must be at least one.
std::vector<std::filesystem::path> FindMaterials(const std::vector<std::string>& patterns,
                                                 const std::filesystem::path& study_file,
                                                 const std::vector<std::filesystem::path>& folders);

// A copy of the study file beside its results: `dir`/study.yaml.
void KeepStudyFile(const std::filesystem::path& study, const std::filesystem::path& dir);

}  // namespace gonio
