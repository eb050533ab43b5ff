// SPDX-License-Identifier: Apache-2.0
// gonio study, kind: frontier.

#pragma once

#include <filesystem>

#include "apps/gonio/commands.h"

namespace gonio {

// Runs the contestants of a study file over its materials (docs/frontier.md), prints the tables and
// leaves them with the figures in options.out. Returns an exit code; throws as commands do.
int FrontierStudy(const StudyOptions& options, const std::filesystem::path& study_file);

}  // namespace gonio
