// SPDX-License-Identifier: Apache-2.0
// A conversation with a Grbl that says whatever it likes: it ends, and nothing is believed that
// was not said.
#include "core/check.h"
#include "drivers/grbl_line.h"
#include "tests/fuzz/scripted_link.h"

namespace gonio::grbl {
namespace {

// What is done next, by the number of it.
bool Disconnected(Line& line, std::size_t turn) {
  const auto gone = [](const auto& result) {
    return !result && result.error().code == ErrorCode::kDisconnected;
  };
  const bool answers = !line.condition().homing() && !line.condition().blocked();
  switch (turn % 5) {
    case 0:
      return gone(line.Hear(Seconds(0)));
    case 1:
      return gone(line.AskStatus());
    case 2:
      return answers && gone(line.Tell("$$"));
    case 3:
      return answers && gone(line.StartHoming());
    default:
      return turn % 15 == 4 && gone(line.Reset());
  }
}

}  // namespace
}  // namespace gonio::grbl

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  auto script = std::make_unique<gonio::ScriptedLink>(gonio::TextOf(data, size));
  const gonio::ScriptedLink& link = *script;
  gonio::grbl::Line line(std::move(script), gonio::Seconds(60));
  const gonio::grbl::Condition& condition = line.condition();
  for (std::size_t turn = 0; turn < 4 * size + 5; ++turn) {
    if (gonio::grbl::Disconnected(line, turn)) break;
    GONIO_CHECK(!condition.homed() || link.said().find("ok") != std::string::npos,
                "it is homed once it said so");
    GONIO_CHECK(!(condition.homed() && condition.homing()), "it is not both");
    GONIO_CHECK(condition.fault().size() < 100, "a fault is said in a few words");
  }
  return 0;
}
