// SPDX-License-Identifier: Apache-2.0
// What events say, as JSON (docs/data-format.md); private to the event log.

#pragma once

#include <nlohmann/json_fwd.hpp>

#include "acquisition/measure.h"
#include "acquisition/radiometry.h"
#include "acquisition/reference_visits.h"
#include "brdf/direction.h"

namespace gonio {

nlohmann::json ToJson(const MeasurerState& state);
nlohmann::json DegreesOf(const HalfDiff& angles);
// Each term that is not zero in all colours: [red, green, blue], null where nothing was measured.
nlohmann::json BudgetOf(const ReducedSample& reduced);
// What the devices said and what was made of it; exposures as they are in their table, counts as
// means over the region.
nlohmann::json BodyOf(const ReferenceRecord& visit);

}  // namespace gonio
