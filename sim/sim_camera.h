// SPDX-License-Identifier: Apache-2.0
// A camera that looks at a Brdf.

#pragma once

#include <memory>

#include "brdf/brdf.h"
#include "drivers/camera.h"
#include "sim/random.h"
#include "sim/sim_config.h"
#include "sim/sim_imager.h"
#include "sim/sim_scene.h"

namespace gonio {

// Exposes the scene by a SimImager whose sensor is the region that is read out. Without `imaging`
// every pixel sees the arms' pair of directions. Where the sample's reflectance for that pair is
// unknown, exposures are refused (kRefused): darkness would be invented. Arms that move while the
// shutter is open smear the frame: the signal is averaged over their way.
class SimCamera final : public Camera {
 public:
  // `sample` and `clock` must outlive it.
  SimCamera(std::string name, const CameraInfo& info, const SimConfig& truth, const Brdf& sample,
            std::unique_ptr<SimScene> scene, Clock& clock, Random random,
            const Imaging& imaging = {}, double gain_db = 0);

  const std::string& name() const override { return name_; }
  const std::string& identity() const override { return identity_; }
  const CameraInfo& info() const override { return info_; }
  Result<Frame> Capture(Seconds exposure, std::stop_token stop) override;
  // Noise comes from `random` from now on.
  void Reseed(Random random) { imager_.Reseed(random); }

 private:
  SimReadout Readout(Seconds exposure) const;
  // Electrons per pixel without noise.
  SimImage Signal(Seconds start, const SimReadout& readout);

  const std::string name_;
  const std::string identity_ = "simulated";
  const CameraInfo info_;
  const SimConfig truth_;
  const Brdf& sample_;
  const std::unique_ptr<SimScene> scene_;
  Clock& clock_;
  const double gain_db_;
  SimImager imager_;
};

}  // namespace gonio
