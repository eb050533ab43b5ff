// SPDX-License-Identifier: Apache-2.0
// A session's samples fitted once more.

#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <vector>

#include "acquisition/session_record.h"
#include "fitting/fit.h"

namespace gonio {

// Fits the samples of `poses`, prints the fit and how far it is from the session's, and writes it
// to OUT/fit.yaml where `out` is not empty. Returns numbers for machines.
nlohmann::json Refit(const std::vector<MeasuredPose>& poses, const Prior& prior,
                     const FitOptions& options, const std::filesystem::path& session,
                     const std::filesystem::path& out);

}  // namespace gonio
