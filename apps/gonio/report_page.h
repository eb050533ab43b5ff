// SPDX-License-Identifier: Apache-2.0
// A session's report as one HTML page.

#pragma once

#include <string>
#include <vector>

#include "apps/gonio/report_facts.h"

namespace gonio {

// The page, whole and self-contained: pictures are inline SVG, nothing is loaded and no script
// runs. Throws std::runtime_error if gnuplot is missing or fails.
std::string ReportPage(const ReportFacts& facts);

// Plain-text sentences about what a reader should know before trusting the numbers; empty if
// nothing was unusual.
std::vector<std::string> Remarks(const ReportFacts& facts);

}  // namespace gonio
