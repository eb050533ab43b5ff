// SPDX-License-Identifier: Apache-2.0
// A reflectance that was estimated from samples, and knows how sure it is.

#pragma once

#include "brdf/brdf.h"

namespace gonio {

struct Prediction {
  Rgb f_r = Rgb::Zero();    // 1/sr
  Rgb sigma = Rgb::Zero();  // standard deviation of f_r, 1/sr
};

struct Interval {
  Rgb low = Rgb::Zero();   // 1/sr, >= 0
  Rgb high = Rgb::Zero();  // 1/sr
};

// Immutable once built; safe to read from several threads.
class Estimate : public Brdf {
 public:
  // Precondition of both: the angles are above the horizon.
  virtual Prediction Predict(const HalfDiff& angles) const = 0;
  // The central interval that holds the true f_r of each channel with this probability, 0 .. 1.
  virtual Interval PredictInterval(const HalfDiff& angles, double probability) const = 0;
};

}  // namespace gonio
