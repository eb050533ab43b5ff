// SPDX-License-Identifier: Apache-2.0
#include "apps/gonio/report_incidents.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <nlohmann/json.hpp>

#include "apps/gonio/plot.h"
#include "apps/gonio/progress.h"

namespace gonio {
namespace {

using nlohmann::json;

constexpr std::size_t kRowsShown = 200;

// Kinds of events whose body has a message, in words.
const std::map<std::string, std::string> kInWords = {
    {"bracket_mismatch", "exposures that do not agree"},
    {"clean_up_failed", "clean-up failed"},
    {"cleared", "interlocks are met"},
    {"continued", "goes on"},
    {"drift_exceeded", "drift"},
    {"error", "error"},
    {"failure", "failure"},
    {"park_failed", "not parked"},
    {"paused", "paused"},
    {"person_called", "a person is called"},
    {"pose_discarded", "pose discarded"},
    {"recovered", "recovered"},
    {"reference_refused", "reference refused"},
    {"suspended", "suspended"},
    {"waiting", "waits before its first move"},
};

}  // namespace

std::optional<Incident> IncidentOf(const SessionEvent& event) {
  const auto words = kInWords.find(event.kind);
  if (words != kInWords.end()) {
    return Incident{event.time, words->second,
                    json::parse(event.body).at("message").get<std::string>()};
  }
  if (event.kind == "session_resumed") {
    const std::size_t changes = json::parse(event.body).at("changes").size();
    return Incident{event.time, "goes on in another process",
                    changes == 0 ? "all as it was" : fmt::format("{} changes accepted", changes)};
  }
  if (event.kind == "resume_reference") {
    const json body = json::parse(event.body);
    return Incident{event.time, "last pose once more",
                    fmt::format("pose {}: {:+.2f} %, standard uncertainty {:.2f} %",
                                body.at("pose").get<int>(), 100 * body.at("change").get<double>(),
                                100 * body.at("sigma_change").get<double>())};
  }
  return std::nullopt;
}

std::string IncidentTable(const std::vector<Incident>& incidents) {
  if (incidents.empty()) return {};
  std::string html =
      "<table class=\"numbers\">\n<tr><th>time</th><th class=\"text\">what</th>"
      "<th class=\"text\">more</th></tr>\n";
  const std::size_t shown = std::min(incidents.size(), kRowsShown);
  for (std::size_t i = 0; i < shown; ++i) {
    const Incident& incident = incidents[i];
    html +=
        fmt::format("<tr><td>{}</td><td class=\"text\">{}</td><td class=\"text\">{}</td></tr>\n",
                    ForPeople(incident.time), incident.what, XmlText(incident.message));
  }
  html += "</table>\n";
  if (shown < incidents.size()) {
    html += fmt::format("<p class=\"caption\">The first {} of {}.</p>\n", shown, incidents.size());
  }
  return html;
}

}  // namespace gonio
