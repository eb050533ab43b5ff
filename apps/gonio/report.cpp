// SPDX-License-Identifier: Apache-2.0
// gonio report: a session as one HTML page with pictures.

#include <fmt/format.h>

#include "apps/gonio/commands.h"
#include "apps/gonio/report_facts.h"
#include "apps/gonio/report_page.h"
#include "core/file.h"

namespace gonio {

int ReportCommand(const ReportOptions& options) {
  const std::filesystem::path out =
      options.out.empty() ? options.session / "report.html" : options.out;
  const std::string page = ReportPage(GatherFacts(options.session));
  WriteFileAtomically(out, [&](std::ostream& stream) { stream << page; });
  fmt::print("wrote            {}\n", out.string());
  return kDone;
}

}  // namespace gonio
