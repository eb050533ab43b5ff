// SPDX-License-Identifier: Apache-2.0
// gonio import: somebody else's measurement as a session.

#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "acquisition/import_session.h"

namespace gonio {

struct ImportOptions {
  std::filesystem::path file;
  std::filesystem::path out;      // a session directory to make
  std::string format = "auto";    // "csv", "rt300s", "cornell", or "auto": by name and header
  std::string bands_nm;           // of cornell: "600-700,500-590,440-490"; empty: these
  std::string prior = "generic";  // "none", "generic" or a prior file
  std::optional<double> min_separation_deg;  // empty: the format's own
};
int ImportCommand(const ImportOptions& options);

// What such an import reads. Throws ConfigError.
ImportedFile ReadForImport(const ImportOptions& options);

}  // namespace gonio
