// SPDX-License-Identifier: Apache-2.0
// What another plan would have done with the sample of a session.

#pragma once

#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>
#include <vector>

#include "acquisition/session_record.h"
#include "apps/gonio/session_setup.h"

namespace gonio {

// Runs the plan to its end on stand-ins: a pose that is near one the session measured has its
// reading, any other has what the session's own estimate says there. So it answers where the plan
// would have looked and what it would have cost; how well it would have fitted, only as far as the
// estimate is true, which is said in what is printed. With `out`: choices.csv there.
nlohmann::json ReplayOtherPlan(const std::string& plan, const SessionSetup& setup,
                               const std::vector<MeasuredPose>& poses, std::uint64_t seed,
                               const std::filesystem::path& session,
                               const std::filesystem::path& out);

}  // namespace gonio
