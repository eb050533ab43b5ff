// SPDX-License-Identifier: Apache-2.0
#include "acquisition/radiometry/stray_light.h"

#include <cmath>

namespace gonio {

Result<MeasuredValue> GlareFraction(const MeasuredValue& dark, const MeasuredValue& field) {
  if (!(field.value > 0)) return Error{ErrorCode::kRefused, "glare: the field is dark"};
  const double g = dark.value / field.value;
  if (!(g < 0.5)) return Error{ErrorCode::kRefused, "glare: the black patch is as bright"};
  return MeasuredValue{g, std::hypot(dark.sigma, g * field.sigma) / field.value};
}

Result<StrayCorrected> SubtractStrayLight(const MeasuredValue& measured,
                                          const MeasuredValue& surround, const StrayLight& stray) {
  const double g = stray.glare.value;
  if (!(g < 1)) return Error{ErrorCode::kRefused, "stray light: a glare of 1 leaves no signal"};
  const double left = 1 - g;
  StrayCorrected result;
  const double around = surround.value - stray.background.value;
  result.rate.value = (measured.value - stray.background.value - g * around) / left;
  // d true / d g = (true - surround) / (1 - g); d true / d background = -1.
  const double by_glare = (result.rate.value - around) / left * stray.glare.sigma;
  result.systematic = std::hypot(stray.background.sigma, by_glare);
  const double noise = std::hypot(measured.sigma, g * surround.sigma) / left;
  result.rate.sigma = std::hypot(noise, result.systematic);
  return result;
}

}  // namespace gonio
