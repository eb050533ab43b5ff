// SPDX-License-Identifier: Apache-2.0
// Lines of a Grbl: decoded, and jogs to where they say that it is.
#include <cmath>
#include <string>
#include <vector>

#include "core/check.h"
#include "drivers/grbl_legs.h"
#include "tests/fuzz/scripted_link.h"

namespace gonio::grbl {
namespace {

void CheckReport(const Report& report) {
  GONIO_CHECK(!report.position.empty() && report.position.size() <= 8, "a position is there");
  GONIO_CHECK(report.offset.size() <= 8, "an offset is one");
  GONIO_CHECK(report.detail >= 0, "details count from 0");
  GONIO_CHECK(TextOf(report.state) != "in an unknown state", "a state has a name");
  for (const double x : report.position) GONIO_CHECK(std::isfinite(x), "positions are finite");
  for (const double x : report.offset) GONIO_CHECK(std::isfinite(x), "offsets are finite");
}

// All axes from where they are to 0, as an operator's rig would.
void CheckLegs(const std::vector<double>& position) {
  std::vector<Way> ways;
  for (int axis = 0; axis < kMostAxes && axis < static_cast<int>(position.size()); ++axis) {
    const double from = position[static_cast<std::size_t>(axis)];
    if (std::abs(from) > 1e5) return;
    ways.push_back({.axis = axis, .from = from, .to = 0, .speed = 1.0 + axis});
  }
  const std::vector<Leg> legs = LegsOf(ways);
  GONIO_CHECK(legs.size() <= kMostAxes, "an axis ends at most one leg");
  for (const Leg& leg : legs) {
    const std::string line = Encode(leg);
    GONIO_CHECK(line.size() < 80 && line.find_first_of("?!~\n\x18") == std::string::npos,
                "a jog is one line");
  }
}

void Check(const Message& message, std::string_view line) {
  switch (message.kind) {
    case Kind::kOk:
      GONIO_CHECK(line == "ok", "nothing else is ok");
      return;
    case Kind::kError:
      GONIO_CHECK(message.code >= 0 && !TextOfError(message.code).empty(), "errors have words");
      return;
    case Kind::kAlarm:
      GONIO_CHECK(message.code >= 0 && !TextOfAlarm(message.code).empty(), "alarms have words");
      return;
    case Kind::kReport:
      CheckReport(message.report);
      CheckLegs(message.report.position);
      return;
    case Kind::kSetting:
      GONIO_CHECK(message.code >= 0 &&
                      line.substr(line.size() - message.text.size()) == message.text &&
                      !message.text.empty(),
                  "a setting has a value");
      return;
    case Kind::kWelcome:
    case Kind::kNote:
      GONIO_CHECK(message.text.size() <= line.size(), "a text is part of its line");
  }
}

}  // namespace
}  // namespace gonio::grbl

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string text = gonio::TextOf(data, size);
  for (std::size_t begin = 0; begin <= text.size();) {
    const std::size_t end = std::min(text.find('\n', begin), text.size());
    const std::string_view line = std::string_view(text).substr(begin, end - begin);
    const auto message = gonio::grbl::Decode(line);
    if (message) gonio::grbl::Check(*message, line);
    begin = end + 1;
  }
  return 0;
}
