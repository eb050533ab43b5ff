// SPDX-License-Identifier: Apache-2.0
#include "sim/sim_camera.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/units.h"

namespace gonio {
namespace {

// Exposures are whole multiples of this, as a sensor's are of its row time.
constexpr double kExposureStep = 1e-6;  // s
// Instants at which a smeared frame is evaluated.
constexpr int kSmearSteps = 16;

}  // namespace

SimCamera::SimCamera(std::string name, const CameraInfo& info, const SimConfig& truth,
                     const Brdf& sample, std::unique_ptr<SimScene> scene, Clock& clock,
                     Random random, const Imaging& imaging, double gain_db)
    : name_(std::move(name)),
      info_(info),
      truth_(truth),
      sample_(sample),
      scene_(std::move(scene)),
      clock_(clock),
      gain_db_(gain_db),
      imager_(truth, imaging, info.width, info.height, random) {}

SimReadout SimCamera::Readout(Seconds exposure) const {
  return {.exposure = exposure,
          .gain_db = gain_db_,
          .black_level = static_cast<double>(truth_.black_level),
          .temperature_c = truth_.temperature_c,
          .layout = info_.layout,
          .full_scale = info_.full_scale};
}

SimImage SimCamera::Signal(Seconds start, const SimReadout& readout) {
  // Of the light; dark current knows nothing of shutters.
  const Seconds exposure = std::max(Seconds(0), readout.exposure + Seconds(truth_.shutter_offset));
  const bool smeared = scene_->MovingBetween(start, start + exposure);
  const int steps = smeared ? kSmearSteps : 1;
  SimImage sum;
  for (int i = 0; i < steps; ++i) {
    const Seconds time = start + exposure * ((i + 0.5) / steps);
    SimImage seen = imager_.See({.arms = scene_->ArmsAt(time),
                                 .power = scene_->PowerAt(time),
                                 .spectrum = scene_->SpectrumAt(time),
                                 .readout = readout},
                                sample_);
    if (i == 0) {
      sum = std::move(seen);
    } else {
      sum += seen;
    }
  }
  const double drift = SlowDrift(truth_.responsivity_drift_per_hour, start);
  return sum *= exposure.count() / steps * drift;
}

Result<Frame> SimCamera::Capture(Seconds exposure, std::stop_token stop) {
  // Also true of NaN.
  if (!(exposure >= info_.min_exposure && exposure <= info_.max_exposure)) {
    return Error{
        ErrorCode::kRefused,
        fmt::format("{}: exposure of {:.6g} s: outside {:.6g} .. {:.6g} s", name_, exposure.count(),
                    info_.min_exposure.count(), info_.max_exposure.count())};
  }
  const Seconds used(std::max(std::round(exposure.count() / kExposureStep), 1.0) * kExposureStep);
  if (auto seen = scene_->Look(); !seen) return seen.error();
  const Seconds start = clock_.Now();
  // To read darkness where the sample's reflectance is unknown would be to invent it.
  const DirectionPair pair = Place(truth_.rig, scene_->ArmsAt(start)).directions();
  if (pair.above_horizon() && !sample_.Eval(pair)) {
    return Error{ErrorCode::kRefused,
                 fmt::format("{}: {} is unknown at theta_i {:.2f}, theta_o {:.2f} deg", name_,
                             sample_.name(), DegFromRad(std::acos(pair.cos_theta_i())),
                             DegFromRad(std::acos(pair.cos_theta_o())))};
  }
  const SimReadout readout = Readout(used);
  const SimImage signal = Signal(start, readout);
  clock_.SleepFor(used + info_.readout + Seconds(truth_.frame_overhead), stop);
  if (stop.stop_requested()) {
    return Error{ErrorCode::kCancelled, fmt::format("{}: exposure: cancelled", name_)};
  }
  Frame frame = imager_.Read(signal, readout);
  frame.start = start;
  return frame;
}

}  // namespace gonio
