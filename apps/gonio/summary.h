// SPDX-License-Identifier: Apache-2.0
// The lines that several commands print about a fit.

#pragma once

#include <string>

#include "acquisition/session.h"
#include "brdf/brdf.h"
#include "brdf/metrics.h"
#include "fitting/fit.h"
#include "fitting/prior.h"

namespace gonio {

// Samples, residuals, convergence, model error, prior.
void PrintFit(const DsbrdfFit& fit, const Prior& prior);

// MALE of `fit` against `truth`, which is called `what`. Returns it.
double PrintMale(const Brdf& truth, const Brdf& fit, const std::string& what);

// Metric options that use every core; the result does not depend on how many there are.
MetricOptions AllCores();

// Warns on standard error if the prior was learned from a material of this name.
void WarnIfSeen(const Prior& prior, const std::string& material);

// The exit code (commands.h) of `gonio` for the way a session ended.
int ExitCodeOf(SessionOutcome outcome);

}  // namespace gonio
