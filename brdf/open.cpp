// SPDX-License-Identifier: Apache-2.0
#include "brdf/open.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <string>

#include "brdf/analytic.h"
#include "brdf/merl_table.h"
#include "brdf/rgl_table.h"
#include "core/error.h"

namespace gonio {

std::unique_ptr<Brdf> OpenBrdf(const std::filesystem::path& path) {
  std::string extension = path.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  if (extension == ".binary") return std::make_unique<MerlTable>(MerlTable::Open(path));
  if (extension == ".bsdf") return std::make_unique<RglTable>(RglTable::Open(path));
  if (extension == ".yaml" || extension == ".yml") return LoadMaterial(path);
  throw ConfigError(fmt::format(
      "{}: has the extension \"{}\", must be .binary (MERL table), .bsdf (RGL) or .yaml (material)",
      path.string(), extension));
}

}  // namespace gonio
