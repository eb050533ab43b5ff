// SPDX-License-Identifier: Apache-2.0
// A camera that looks at a Brdf.

#pragma once

#include <array>
#include <memory>

#include "brdf/brdf.h"
#include "drivers/camera.h"
#include "sim/random.h"
#include "sim/sim_config.h"
#include "sim/sim_scene.h"

namespace gonio {

// Exposes the scene:
//
//   electrons = Poisson(responsivity f_r cos(theta_i) power t (1 + m) + dark t) + read noise
//   counts    = round(electrons / electrons_per_count + black level), clipped to 0 .. full scale
//
// per pixel, with one draw of the multiplicative noise m per frame and channel. Where the
// sample's reflectance is unknown, exposures are refused (kRefused): darkness would be invented.
// Arms that move while the shutter is open smear the frame: the signal is averaged over their way.
class SimCamera final : public Camera {
 public:
  // `sample` and `clock` must outlive it.
  SimCamera(std::string name, const CameraInfo& info, const SimConfig& truth, const Brdf& sample,
            std::unique_ptr<SimScene> scene, Clock& clock, Random random);

  const std::string& name() const override { return name_; }
  const std::string& identity() const override { return identity_; }
  const CameraInfo& info() const override { return info_; }
  Result<Frame> Capture(Seconds exposure, std::stop_token stop) override;

 private:
  // Electrons per pixel without noise, dark current included nowhere.
  Rgb Signal(Seconds start, Seconds exposure) const;
  // Where the arms truly are at one instant.
  DirectionPair Directions(Seconds time) const;
  // f_r cos(theta_i) power at one instant.
  Rgb Radiance(Seconds time) const;
  Frame Expose(const Rgb& signal, Seconds exposure);
  std::uint16_t Count(double signal, double dark);

  const std::string name_;
  const std::string identity_ = "simulated";
  const CameraInfo info_;
  const SimConfig truth_;
  const Brdf& sample_;
  const std::unique_ptr<SimScene> scene_;
  Clock& clock_;
  Random random_;
};

}  // namespace gonio
