// SPDX-License-Identifier: Apache-2.0
#include "acquisition/calibration/calibration_status.h"

#include <fmt/format.h>

#include <cmath>

#include "acquisition/radiometry/calibration_products.h"
#include "acquisition/radiometry/measured_value.h"
#include "core/error.h"

namespace gonio {
namespace {

std::string Text(const MeasuredValue& e) {
  return fmt::format("{:.4g} +- {:.2g}", e.value, e.sigma);
}

std::string Numbers(const DarkLibrary& dark) {
  std::string text =
      fmt::format("noise {:.3f} counts, {:.4g} counts/s",
                  std::sqrt(dark.fits.front().read_variance), Median(dark.fits.front().rate));
  if (dark.fits.size() > 1) text += fmt::format(", {} temperatures", dark.fits.size());
  return text;
}

std::string Numbers(const SensorCalibration& sensor) {
  const MeasuredValue& late = sensor.exposure_offset;
  return fmt::format("gain {} e/count, read noise {} e, full well {} e, exposures {} us late, {}",
                     Text(sensor.gain), Text(sensor.read_noise), Text(sensor.full_well),
                     Text({1e6 * late.value, 1e6 * late.sigma}),
                     sensor.linearity.is_identity() ? "linear" : "linearity corrected");
}

std::string Numbers(const BadPixels& bad) {
  return fmt::format("{} hot, {} noisy, {} dead", bad.hot, bad.noisy, bad.dead);
}

std::string Numbers(const FlatField& flat) {
  const RobustSpread spread = RobustSpreadOf(flat.response);
  return fmt::format("pattern {:.2f} %", 100 * spread.sigma);
}

std::string Numbers(const ColourFlats& flats) {
  std::string text;
  for (const FlatField& flat : flats) text += (text.empty() ? "" : ", ") + Numbers(flat);
  return text;
}

std::string Numbers(const StrayLights& stray) {
  return fmt::format("background {}, {}, {} e/s; glare {}, {}, {}", Text(stray[0].background),
                     Text(stray[1].background), Text(stray[2].background), Text(stray[0].glare),
                     Text(stray[1].glare), Text(stray[2].glare));
}

std::string Numbers(const Responsivity& r) {
  return fmt::format("{}, {}, {} e/s/(1/sr) by {}", Text(r.responsivity[0]),
                     Text(r.responsivity[1]), Text(r.responsivity[2]), r.standard);
}

// `colours`: of a light that has them.
std::string NumbersOf(CalibrationKind kind, const std::filesystem::path& path,
                      const CalibrationDemand& demand, bool colours) {
  switch (kind) {
    case CalibrationKind::kDark:
      return Numbers(ReadDark(path, demand));
    case CalibrationKind::kPhotonTransfer:
      return Numbers(ReadSensor(path, demand));
    case CalibrationKind::kBadPixels:
      return Numbers(ReadBadPixels(path, demand));
    case CalibrationKind::kFlatField:
      return colours ? Numbers(ReadColourFlats(path, demand))
                     : Numbers(ReadFlatField(path, demand));
    case CalibrationKind::kStrayLight:
      return Numbers(ReadStrayLight(path, demand));
    case CalibrationKind::kResponsivity:
      return Numbers(ReadResponsivity(path, demand));
  }
  return "";
}

}  // namespace

std::vector<CalibrationStatus> StatusOf(const CalibrationPolicy& policy, std::int64_t now) {
  std::vector<CalibrationStatus> all;
  for (const CalibrationKind kind : kCalibrationKinds) {
    CalibrationStatus& status = all.emplace_back();
    status.kind = kind;
    const std::filesystem::path path = policy.folder / FileNameOf(kind);
    if (!std::filesystem::exists(path)) continue;
    try {
      status.header = ReadCalibrationHeader(path);
      CalibrationDemand demand;
      demand.format = status.header->format;  // whatever camera it is for
      demand.now = now;
      status.old = static_cast<double>(now - status.header->created) > policy.max_age;
      status.numbers = NumbersOf(kind, path, demand, !status.header->light.empty());
    } catch (const ConfigError& e) {
      status.problem = e.what();
    }
  }
  return all;
}

}  // namespace gonio
