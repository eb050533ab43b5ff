// SPDX-License-Identifier: Apache-2.0
// What every fitted DSBRDF is, however it was fitted: K lobes at each theta_d.

#pragma once

#include <vector>

#include "brdf/brdf.h"

namespace gonio {

// exp(kappa cos^gamma theta_h) - 1 [1/sr]: an unnormalised Hemi-EPD lobe (fitting/hemi_epd.h).
struct Lobe {
  double kappa = 0;  // >= 0: the lobe's height is exp(kappa) - 1
  double gamma = 1;  // > 0: small is broad, large is narrow
};

// f(theta_h, theta_d) = sum of LobesAt(theta_d, channel), each at theta_h.
class LobeModel : public Brdf {
 public:
  virtual int lobes() const = 0;
  // Precondition: 0 <= channel < kChannels. theta_d [rad] is clamped to [0, pi/2]. Empty for a
  // channel that could not be fitted; else lobes() of them, in the model's own order.
  virtual std::vector<Lobe> LobesAt(double theta_d, int channel) const = 0;
};

}  // namespace gonio
