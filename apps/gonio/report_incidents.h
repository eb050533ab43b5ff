// SPDX-License-Identifier: Apache-2.0
// What came between the poses of a session: failures, interlocks, pauses, resumes.

#pragma once

#include <optional>
#include <string>
#include <vector>

#include "acquisition/session_record.h"
#include "core/clock.h"

namespace gonio {

struct Incident {
  Seconds time{0};   // session clock
  std::string what;  // "failure", "suspended by an interlock", ...
  std::string message;
};

// Of an event that is one. Precondition: its body is that of its kind (docs/data-format.md).
std::optional<Incident> IncidentOf(const SessionEvent& event);

// A table of them, as HTML; empty without any.
std::string IncidentTable(const std::vector<Incident>& incidents);

}  // namespace gonio
