// SPDX-License-Identifier: Apache-2.0
// A frontier study's results as JSON. NaN is null.

#pragma once

#include <nlohmann/json_fwd.hpp>

#include "apps/gonio/frontier_result.h"
#include "apps/gonio/frontier_summary.h"

namespace gonio {

nlohmann::json ToJson(const FrontierCell& cell);
nlohmann::json ToJson(const DenseCell& cell);
nlohmann::json ToJson(const ContestantSummary& summary);

// Throw nlohmann::json::exception on anything else.
FrontierCell FrontierCellFromJson(const nlohmann::json& json);
DenseCell DenseCellFromJson(const nlohmann::json& json);

}  // namespace gonio
