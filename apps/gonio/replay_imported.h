// SPDX-License-Identifier: Apache-2.0
// gonio replay of a session that another instrument measured.

#pragma once

#include "acquisition/session_record.h"
#include "apps/gonio/commands.h"

namespace gonio {

// No decision of it is ours; what can be made once more are its samples, from the file it keeps,
// its fit, and what a plan of ours would have chosen on the rig of `options`.
int ReplayImported(const ReplayOptions& options, const SessionRecord& record);

}  // namespace gonio
