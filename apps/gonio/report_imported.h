// SPDX-License-Identifier: Apache-2.0
// What a report says of samples that somebody else's instrument measured.

#pragma once

#include <string>
#include <utility>
#include <vector>

#include "apps/gonio/report_facts.h"

namespace gonio {

bool IsImported(const ReportFacts& facts);
// An entry of SessionInfo::imported; empty if there is none.
std::string ImportedFact(const ReportFacts& facts, const std::string& key);

// What is known of the source, for a table: name and text.
std::vector<std::pair<std::string, std::string>> SourceRows(const ReportFacts& facts);

// Samples with a channel below zero that is usable, and those where none is usable.
int NegativeSamples(const SessionRecord& session);
int UnusableSamples(const SessionRecord& session);

}  // namespace gonio
