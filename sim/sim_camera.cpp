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
                     Random random)
    : name_(std::move(name)),
      info_(info),
      truth_(truth),
      sample_(sample),
      scene_(std::move(scene)),
      clock_(clock),
      random_(random) {}

DirectionPair SimCamera::Directions(Seconds time) const {
  const SimArms arms = scene_->ArmsAt(time);
  return {FromSpherical(kPi / 2 - arms[1], arms[0]), FromSpherical(kPi / 2 - arms[3], arms[2])};
}

Rgb SimCamera::Radiance(Seconds time) const {
  const DirectionPair pair = Directions(time);
  const Rgb f_r = sample_.Eval(pair).value_or(Rgb::Zero());
  return f_r.max(0) * std::max(pair.cos_theta_i(), 0.0) * scene_->PowerAt(time);
}

Rgb SimCamera::Signal(Seconds start, Seconds exposure) const {
  const bool smeared = scene_->MovingBetween(start, start + exposure);
  const int steps = smeared ? kSmearSteps : 1;
  Rgb sum = Rgb::Zero();
  for (int i = 0; i < steps; ++i) sum += Radiance(start + exposure * ((i + 0.5) / steps));
  return truth_.responsivity * sum * (exposure.count() / steps);
}

std::uint16_t SimCamera::Count(double signal, double dark) {
  double electrons = signal + dark;
  if (truth_.shot_noise) electrons = random_.Poisson(electrons);
  if (truth_.full_well > 0) electrons = std::min(electrons, truth_.full_well);
  if (truth_.read_noise > 0) electrons += truth_.read_noise * random_.Normal();
  const double count = std::round(electrons / truth_.electrons_per_count + truth_.black_level);
  return static_cast<std::uint16_t>(std::clamp(count, 0.0, static_cast<double>(info_.full_scale)));
}

Frame SimCamera::Expose(const Rgb& signal, Seconds exposure) {
  Frame frame;
  frame.width = info_.width;
  frame.height = info_.height;
  frame.layout = info_.layout;
  frame.exposure = exposure;
  frame.black_level = truth_.black_level;
  std::array<double, kChannels> seen{};
  for (int c = 0; c < kChannels; ++c) {
    seen[c] = std::max(0.0, signal[c] * (1 + truth_.multiplicative_noise * random_.Normal()));
  }
  const double dark = truth_.dark_current * exposure.count();
  frame.counts.resize(info_.counts());
  for (std::size_t i = 0; i < frame.counts.size(); ++i) {
    frame.counts[i] = Count(seen[i % kChannels], dark);
  }
  return frame;
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
  const DirectionPair pair = Directions(start);
  if (pair.above_horizon() && !sample_.Eval(pair)) {
    return Error{ErrorCode::kRefused,
                 fmt::format("{}: {} is unknown at theta_i {:.2f}, theta_o {:.2f} deg", name_,
                             sample_.name(), DegFromRad(std::acos(pair.cos_theta_i())),
                             DegFromRad(std::acos(pair.cos_theta_o())))};
  }
  const Rgb signal = Signal(start, used);
  clock_.SleepFor(used + info_.readout, stop);
  if (stop.stop_requested()) {
    return Error{ErrorCode::kCancelled, fmt::format("{}: exposure: cancelled", name_)};
  }
  Frame frame = Expose(signal, used);
  frame.start = start;
  return frame;
}

}  // namespace gonio
