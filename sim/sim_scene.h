// SPDX-License-Identifier: Apache-2.0
// What a simulated camera looks at: where the arms are and how bright the lamp is.

#pragma once

#include <array>
#include <memory>

#include "core/clock.h"
#include "core/error.h"
#include "drivers/axis.h"
#include "drivers/light.h"
#include "sim/sim_config.h"
#include "sim/sim_light.h"
#include "sim/sim_motor.h"

namespace gonio {

// In the order of SimAxisNames(); null where a rig has no axis.
using SimMotors = std::array<std::shared_ptr<SimMotor>, 4>;

class SimScene {
 public:
  virtual ~SimScene() = default;
  // When the shutter opens. An error: there is nothing to be seen, and the camera reports it.
  virtual Result<void> Look() = 0;
  // Where the axes truly stand.
  virtual SimArms ArmsAt(Seconds time) const = 0;
  virtual bool MovingBetween(Seconds begin, Seconds end) const = 0;
  virtual double PowerAt(Seconds time) const = 0;  // of the lamp, relative to full power
  virtual Rgb SpectrumAt(Seconds time) const = 0;  // as SimLamp::SpectrumAt()
};

// The sum of angles, one by one.
SimArms operator+(const SimArms& a, const SimArms& b);

// The truth about a simulated machine, whatever its encoders say. `offset`: of the axes from where
// their motors stand (SimConfig::axis_offset).
class MotorScene final : public SimScene {
 public:
  MotorScene(SimMotors motors, std::shared_ptr<const SimLamp> lamp, const SimArms& offset = {});
  Result<void> Look() override { return {}; }
  SimArms ArmsAt(Seconds time) const override;
  bool MovingBetween(Seconds begin, Seconds end) const override;
  double PowerAt(Seconds time) const override { return lamp_->PowerAt(time); }
  Rgb SpectrumAt(Seconds time) const override { return lamp_->SpectrumAt(time); }

 private:
  const SimMotors motors_;
  const std::shared_ptr<const SimLamp> lamp_;
  const SimArms offset_;
};

// Real axes and a real light, as they are read back when the shutter opens: a simulated camera on a
// machine that has no camera yet. The devices outlive it; all calls on them are made by Look().
// `offset`: of the axes from what is read; axes that the rig does not have are null; `crosstalk`:
// of a light with colours (SpectrumOf).
class ReadbackScene final : public SimScene {
 public:
  ReadbackScene(const std::array<Axis*, 4>& axes, Light* light, const SimArms& offset = {},
                double crosstalk = 0)
      : axes_(axes), light_(light), offset_(offset), crosstalk_(crosstalk) {}
  // kProtocol: an axis moves.
  Result<void> Look() override;
  SimArms ArmsAt(Seconds) const override { return arms_; }
  bool MovingBetween(Seconds, Seconds) const override { return false; }
  double PowerAt(Seconds) const override { return power_; }
  Rgb SpectrumAt(Seconds) const override { return spectrum_; }

 private:
  const std::array<Axis*, 4> axes_;
  Light* const light_;
  const SimArms offset_;
  const double crosstalk_;
  SimArms arms_{};
  double power_ = 0;
  Rgb spectrum_ = Rgb::Ones();
};

}  // namespace gonio
