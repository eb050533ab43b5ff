// SPDX-License-Identifier: Apache-2.0
#include "apps/gonio/frontier_reconstruction.h"

#include "core/check.h"
#include "fitting/fit.h"
#include "fitting/pca_reflectance.h"
#include "fitting/process_fit.h"
#include "fitting/scattered_reflectance.h"

namespace gonio {

std::unique_ptr<Brdf> Reconstruct(Reconstruction how, std::span<const BrdfSample> samples,
                                  const Plan& plan, const Knowledge* learned) {
  switch (how) {
    case Reconstruction::kDsbrdf:
      return std::make_unique<DsbrdfFit>(FitDsbrdf(samples, plan.prior, plan.fit));
    case Reconstruction::kProcess:
      return FitProcess(samples, plan.prior);
    case Reconstruction::kPca:
      GONIO_CHECK(learned != nullptr && learned->pca != nullptr, "components were learned");
      return Reconstruct(samples, *learned->pca);
    case Reconstruction::kScattered:
      return InterpolateScattered(samples);
  }
  GONIO_CHECK(false, "every kind of reconstruction is handled");
}

}  // namespace gonio
