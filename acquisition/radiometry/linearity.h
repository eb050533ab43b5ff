// SPDX-License-Identifier: Apache-2.0
// How far a sensor's counts are from proportional to the light, and their correction.
//
// A series of flats of known relative light x = exposure x monitor gives counts above black y(x).
// The straight line is y = s x, with s such that the *relative* deviations are least (EMVA 1288
// release 4.0, section 7): a deviation of 1 % matters as much in the shadows as in the lights.
// Each exposure's deviation becomes a knot of the table: counts y -> factor s x / y. Between the
// knots the factor is linear in y; below the first it is the first's, also for negative counts.
// Above the last nothing is known, and nothing is corrected.
//
// The light's own noise (1 % is common) is in every knot, so the table has an uncertainty which
// doesn't average out over pixels or poses. If no deviation stands out of it, the identity table
// is the better one: `significant` says so.

#pragma once

#include <optional>
#include <vector>

#include "acquisition/radiometry/measured_value.h"
#include "acquisition/radiometry/photon_transfer.h"

namespace gonio {

struct LinearityKnot {
  double counts = 0;     // above black, as read
  MeasuredValue factor;  // corrected counts over counts
};

class Linearity {
 public:
  // Corrects nothing up to `max_counts` above black.
  static Linearity Identity(double max_counts);
  // Knots in any order, at least one; counts > 0 and different, or kRefused.
  static Result<Linearity> FromKnots(std::vector<LinearityKnot> knots);

  // What to multiply counts above black with. Empty above the last knot.
  std::optional<MeasuredValue> Factor(double counts) const;
  std::optional<double> Correct(double counts) const;

  const std::vector<LinearityKnot>& knots() const { return knots_; }  // ascending in counts
  double max_counts() const { return knots_.back().counts; }
  // Whether all factors are one: frames can be left alone.
  bool is_identity() const;

 private:
  std::vector<LinearityKnot> knots_;
};

struct LinearityOptions {
  int channel = 0;
  double dark_rate = 0;    // counts/s that come without light
  double light_noise = 0;  // relative, of one frame: monitor and multiplicative noise
  double min_counts = 0;   // fainter points are left out: black level's error rules there
};

struct LinearityFit {
  Linearity table = Linearity::Identity(1);
  double slope = 0;               // s, counts per second of light 1
  double max_residual = 0;        // largest |deviation| from the line, relative
  double max_residual_sigma = 0;  // of that one
  double chi_squared = 0;         // of "there is no deviation"
  int degrees_of_freedom = 0;     // what it is then
  // chi_squared is so large that it happens once in a thousand times if the sensor is linear.
  bool significant = false;
};

// From the points of a photon transfer series that are not clipped. kRefused with fewer than three.
Result<LinearityFit> MeasureLinearity(const std::vector<TransferPoint>& points,
                                      const LinearityOptions& options);

}  // namespace gonio
