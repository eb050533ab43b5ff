// SPDX-License-Identifier: Apache-2.0
// Pictures of fits.

#pragma once

#include "apps/gonio/plot.h"
#include "brdf/brdf.h"
#include "fitting/lobe_model.h"

namespace gonio {

struct SliceFigureOptions {
  double theta_d = 0;  // rad
  int channel = 1;
  int keep_every = 1;  // which theta_h of the reference are shown
};

// One slice (figures 3 to 5 of Edahiro et al.): the data, if there is a reference (averaged over
// phi_d at the nearest theta_d of a MERL table), each fitted lobe, and their sum. Throws
// ConfigError if the model does not know the channel.
Plot LobesPlot(const LobeModel& model, const Brdf* reference, const SliceFigureOptions& options);

// Where in (theta_h, theta_d) the error of `other` sits (ErrorMap of brdf/metrics.h).
Plot ErrorMapPlot(const Brdf& reference, const Brdf& other, int channel);

}  // namespace gonio
