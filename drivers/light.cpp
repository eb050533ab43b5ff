// SPDX-License-Identifier: Apache-2.0
#include "drivers/light.h"

namespace gonio {

const char* ToString(LightColour colour) {
  switch (colour) {
    case LightColour::kRed:
      return "red";
    case LightColour::kGreen:
      return "green";
    case LightColour::kBlue:
      break;
  }
  return "blue";
}

Result<void> Light::Select(LightColour colour, std::stop_token) {
  return Error{ErrorCode::kRefused, name() + ": has no " + ToString(colour)};
}

Result<std::optional<LightColour>> Light::Selected() { return std::optional<LightColour>(); }

}  // namespace gonio
