// SPDX-License-Identifier: Apache-2.0
// A frontier study's results as tables, for the terminal and for documents.

#pragma once

#include <string>
#include <vector>

#include "apps/gonio/frontier_result.h"
#include "apps/gonio/frontier_summary.h"

namespace gonio {

// Columns of text under headings; the first is left-aligned.
struct TextTable {
  std::string title;
  std::vector<std::string> head;
  std::vector<std::vector<std::string>> rows;
};

// Error by budget; what being as good as the dense scan takes; stops; coverage. Those that would be
// empty are left out.
std::vector<TextTable> MakeTables(const FrontierResult& result,
                                  const std::vector<ContestantSummary>& summaries);

std::string ToPlainText(const TextTable& table);
// The whole document, ready to be pasted.
std::string ToMarkdown(const FrontierResult& result, const std::vector<TextTable>& tables);

}  // namespace gonio
