// SPDX-License-Identifier: Apache-2.0
#include "apps/gonio/frontier_reconstruction.h"

#include "core/check.h"
#include "fitting/fit.h"
#include "fitting/process_fit.h"

namespace gonio {

std::unique_ptr<Brdf> Reconstruct(Reconstruction how, std::span<const BrdfSample> samples,
                                  const Plan& plan, const Knowledge*) {
  switch (how) {
    case Reconstruction::kDsbrdf:
      return std::make_unique<DsbrdfFit>(FitDsbrdf(samples, plan.prior, plan.fit));
    case Reconstruction::kProcess:
      return FitProcess(samples, plan.prior);
  }
  GONIO_CHECK(false, "every kind of reconstruction is handled");
}

}  // namespace gonio
