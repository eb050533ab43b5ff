// SPDX-License-Identifier: Apache-2.0
// Pictures of a study.

#pragma once

#include "apps/gonio/plot.h"
#include "apps/gonio/study_result.h"

namespace gonio {

// Error against density (figure 6 of Edahiro et al.): every material and the median, a panel for
// each method, or only for `method` if it is not empty. Throws ConfigError if nothing was fitted.
Plot DensityPlot(const StudyResult& study, const std::string& method);

}  // namespace gonio
