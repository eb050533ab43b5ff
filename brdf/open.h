// SPDX-License-Identifier: Apache-2.0
// Opens reflectance of any kind that a file can hold.

#pragma once

#include <filesystem>
#include <memory>

#include "brdf/brdf.h"

namespace gonio {

// By extension, in either case: .binary is a MerlTable, .bsdf an RglTable, .yaml or .yml an
// analytic material. Throws ConfigError "PATH: ..." on a missing file, any other extension, and
// whatever the readers refuse.
std::unique_ptr<Brdf> OpenBrdf(const std::filesystem::path& path);

}  // namespace gonio
