// SPDX-License-Identifier: Apache-2.0
// The pictures of a session's report.

#pragma once

#include <optional>
#include <string>

#include "apps/gonio/plot.h"
#include "apps/gonio/report_facts.h"
#include "core/units.h"

namespace gonio {

struct Figure {
  Plot plot;
  std::string caption;  // plain text: what is seen, with units
};

// Where on the (theta_h, theta_d) map was measured, and in which order.
Figure PoseMapFigure(const ReportFacts& facts);

// f_r over theta_o in the plane of incidence, scan by scan, on an axis that shows what is below
// zero. Empty without three readings in the plane at one theta_i.
std::optional<Figure> ReadingsFigure(const ReportFacts& facts);

// f_r over theta_h at one theta_d [rad]: fit, band, truth and the samples nearby. No caption: a
// page shows several and describes them once. Precondition: facts.fit.
Figure SliceFigure(const ReportFacts& facts, double theta_d);
inline constexpr double kSliceReach = 4 * kPi / 180;  // rad: samples this near in theta_d are shown

// Error and expected error over the number of poses. Precondition: HasErrorFigure().
Figure ErrorFigure(const ReportFacts& facts);
bool HasErrorFigure(const ReportFacts& facts);

// Hours of the dense scan, the thinned scan and this session.
Figure DurationFigure(const ReportFacts& facts);

// kappa and gamma of the lobes over theta_d, all channels. Precondition: facts.fit.
Figure LobeFigure(const ReportFacts& facts);

}  // namespace gonio
