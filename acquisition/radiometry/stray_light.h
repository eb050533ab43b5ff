// SPDX-License-Identifier: Apache-2.0
// Light that reaches the sensor by other ways than the sample.
//
// Two parts, both per channel, in the rates of region_statistics.h:
//
//   measured = (1 - g) true + g (surround - background) + background
//
// background [electrons/s at light 1]: room light and walls, what a black trap in the sample's
// place reads. g: the veiling glare of the lens, the share of a pixel's light that comes from the
// rest of the image, `surround` being the image's mean rate as measured (ISO 9358:1994; integral
// method: a black patch in a bright field reads g of the image's mean). The background is as the
// trap read it, its own glare included.

#pragma once

#include "acquisition/radiometry/measured_value.h"
#include "core/error.h"

namespace gonio {

struct StrayLight {
  MeasuredValue background;   // electrons/s at light 1; same unit as the rates it is taken from
  MeasuredValue glare{0, 0};  // g, 0 .. 1
};

// g from a black patch in a bright field, both after the background is taken off: dark / field,
// where `field` is the mean rate of the image, the patch included.
// kRefused unless the field is > 0 and g below 1/2. A g below zero within its noise is kept.
Result<MeasuredValue> GlareFraction(const MeasuredValue& dark, const MeasuredValue& field);

// The true rate and its whole sigma; `systematic`: the part that background and g contribute, the
// same in all measurements. kRefused if g.value is not below 1.
struct StrayCorrected {
  MeasuredValue rate;
  double systematic = 0;
};
Result<StrayCorrected> SubtractStrayLight(const MeasuredValue& measured,
                                          const MeasuredValue& surround, const StrayLight& stray);

}  // namespace gonio
