// SPDX-License-Identifier: Apache-2.0
// The pictures a study leaves in its folder.

#pragma once

#include <filesystem>
#include <vector>

#include "apps/gonio/study_config.h"
#include "apps/gonio/study_result.h"

namespace gonio {

// DIR/figures: density.svg and .png, and, for the materials of the study's montage, montages of
// renders (montage-point.png, montage-env.png), a slice and an error map of the full density each.
// Throws std::runtime_error.
void WriteStudyPictures(const StudyConfig& study,
                        const std::vector<std::filesystem::path>& materials,
                        const StudyResult& result, const std::filesystem::path& dir);

}  // namespace gonio
