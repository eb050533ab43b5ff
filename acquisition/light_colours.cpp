// SPDX-License-Identifier: Apache-2.0
#include "acquisition/light_colours.h"

#include <algorithm>
#include <iterator>

namespace gonio {

LightColour ColourNamed(const std::string& name) {
  for (const LightColour colour : kLightColours) {
    if (name == ToString(colour)) return colour;
  }
  throw ConfigError("there is no colour " + name);
}

std::vector<std::optional<LightColour>> ColoursInTurn(const RigConfig& rig,
                                                      const std::optional<LightColour>& last) {
  if (!rig.by_colour) return {std::nullopt};
  std::vector<std::optional<LightColour>> turns(std::begin(kLightColours), std::end(kLightColours));
  if (last == turns.back()) std::reverse(turns.begin(), turns.end());
  return turns;
}

Result<void> ColourChanger::Select(LightColour colour, std::stop_token stop) {
  if (selected_ == colour) {
    const auto lit = devices_.light->Selected();
    if (!lit) return lit.error();
    if (*lit == colour) return {};
  }
  selected_.reset();
  if (const auto done = devices_.light->Select(colour, stop); !done) {
    if (done.error().code != ErrorCode::kRefused) return done;
    return Error{ErrorCode::kProtocol, done.error().message};
  }
  if (const auto told = devices_.monitor->Expect(colour); !told) return told;
  clock_.SleepFor(rig_.colour_settle, stop);
  if (stop.stop_requested()) return Error{ErrorCode::kCancelled, "change of colour: cancelled"};
  selected_ = colour;
  return {};
}

}  // namespace gonio
