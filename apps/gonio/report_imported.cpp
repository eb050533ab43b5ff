// SPDX-License-Identifier: Apache-2.0
#include "apps/gonio/report_imported.h"

#include <algorithm>

namespace gonio {
namespace {

template <typename Predicate>
int CountSamples(const SessionRecord& session, const Predicate& predicate) {
  const std::vector<BrdfSample> samples = session.Samples();
  return static_cast<int>(std::count_if(samples.begin(), samples.end(), predicate));
}

}  // namespace

bool IsImported(const ReportFacts& facts) { return !facts.session.info.imported.empty(); }

std::string ImportedFact(const ReportFacts& facts, const std::string& key) {
  const auto found = facts.session.info.imported.find(key);
  return found == facts.session.info.imported.end() ? "" : found->second;
}

std::vector<std::pair<std::string, std::string>> SourceRows(const ReportFacts& facts) {
  return {{"Sample", ImportedFact(facts, "title")},
          {"Imported from", ImportedFact(facts, "file") + ", as " + ImportedFact(facts, "format")},
          {"Values", ImportedFact(facts, "quantity")},
          {"Channels", ImportedFact(facts, "channels")},
          {"Raw frames", ImportedFact(facts, "raw_frames")},
          {"Measured", ImportedFact(facts, "started")}};
}

int NegativeSamples(const SessionRecord& session) {
  return CountSamples(session, [](const BrdfSample& sample) {
    return (sample.f_r < 0 && sample.sigma.isFinite()).any();
  });
}

int UnusableSamples(const SessionRecord& session) {
  return CountSamples(session,
                      [](const BrdfSample& sample) { return !sample.sigma.isFinite().any(); });
}

}  // namespace gonio
