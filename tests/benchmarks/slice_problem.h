// SPDX-License-Identifier: Apache-2.0
// One material's slices, fitted by each method: what both our own benchmark and the comparison with
// SciPy time. 18 theta_d x 3 colours x 90 theta_h.

#pragma once

#include <string>
#include <vector>

#include "brdf/open.h"
#include "fitting/fit.h"
#include "fitting/slice_data.h"
#include "fitting/slice_em.h"
#include "fitting/slice_joint.h"
#include "fitting/starts.h"
#include "fitting/table_fit.h"

namespace gonio {

struct SliceProblem {
  explicit SliceProblem(const Brdf& material) : slices(SlicesOf(material, {})) {
    for (const SliceData& slice : slices) {
      for (int c = 0; c < kChannels; ++c) {
        if (WhyNotFittable(slice.points[c], em.lobes)) continue;
        points[c].push_back(slice.points[c]);
      }
    }
    samples = SamplesOf(slices, {true, true, true});
    start = FitStarts(samples, prior)[2];
  }

  std::vector<SliceFit> Em() const {
    std::vector<SliceFit> fits;
    for (const auto& channel : points) {
      for (const auto& slice : channel) fits.push_back(FitSliceEm(slice, em));
    }
    return fits;
  }
  std::vector<SliceFit> Joint() const {
    std::vector<SliceFit> fits;
    for (const auto& channel : points) {
      const std::vector<SliceFit> some = FitSlicesJoint(channel, joint);
      fits.insert(fits.end(), some.begin(), some.end());
    }
    return fits;
  }
  // One minimisation from one start, as that is what a solver can be compared on.
  FitSummary Continuous() const {
    return RefitDsbrdf(samples, prior, continuous, start, continuous.model_error).summary();
  }

  std::vector<SliceData> slices;
  std::vector<std::vector<SlicePoint>> points[kChannels];  // of the slices that can be fitted
  EmOptions em;
  JointOptions joint;
  FitOptions continuous = TableFitOptions{}.continuous;
  Prior prior = GenericPrior({.lobes = em.lobes, .knots = TableFitOptions{}.knots});
  std::vector<BrdfSample> samples;
  Eigen::VectorXd start;
};

}  // namespace gonio
