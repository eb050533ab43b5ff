// SPDX-License-Identifier: Apache-2.0
// Renders side by side, with labels.

#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "brdf/render/image.h"

namespace gonio {

struct MontageTile {
  std::string label;  // shown above the tile; may be empty
  Image tone_mapped;  // all tiles of a montage are of one size
};
struct MontageRow {
  std::string label;  // shown at the left; may be empty
  std::vector<MontageTile> tiles;
};

// One PNG. Throws ConfigError if `path` is no .png, std::runtime_error if it cannot be written.
void WriteMontage(const std::filesystem::path& path, const std::vector<MontageRow>& rows);

}  // namespace gonio
