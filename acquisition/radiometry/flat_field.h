// SPDX-License-Identifier: Apache-2.0
// How each site answers to the light compared with the others of its channel.
//
// Frames of an evenly lit, matt surface (or many random positions of it, so that its own grain
// averages out) give per site the ratio to the mean of its channel over the good sites:
//
//   F(p) = sum_k e_k(p) / sum_k mean_k,   mean over the good sites of a channel = 1
//
// It holds the sensor's pattern and whatever the optics do to even light: vignetting, dust. That
// the surface was even is the caller's word; what it was not goes into F unseen.
//
// sigma(F)^2 = sum_k (mean_k F(p) + f_k) / (sum_k mean_k)^2. It is the same error in all frames
// corrected with this F: over a region of N sites it falls as 1 / sqrt(N), over poses it does not.

#pragma once

#include <vector>

#include "acquisition/radiometry/frame_correction.h"
#include "acquisition/radiometry/hdr_merge.h"
#include "acquisition/radiometry/measured_value.h"

namespace gonio {

struct FlatField {
  SensorFormat format;
  SiteImage response;  // 1 of bad sites
  SiteImage sigma;     // infinite of bad sites
};

// kRefused without frames, with frames of different formats, or a channel without signal or good
// sites. A site that is unusable in any frame is bad.
Result<FlatField> MeasureFlatField(const std::vector<CorrectedFrame>& frames);

// Divides rates by the response, and their variances by its square. The flat's own error is not
// added: it is systematic (FlatTerm). kRefused if the formats differ.
Result<void> ApplyFlatField(const FlatField& flat, MergedImage* image);

// Relative standard uncertainty that the flat leaves in the mean over these sites, each weighing
// the same: sqrt(sum sigma^2 / response^2) / N. Bad sites are left out.
double FlatTerm(const FlatField& flat, const std::vector<std::uint32_t>& sites);

}  // namespace gonio
