// SPDX-License-Identifier: Apache-2.0
// An axis without a machine.

#pragma once

#include <memory>
#include <mutex>

#include "drivers/axis.h"
#include "sim/random.h"
#include "sim/sim_motor.h"

namespace gonio {

struct SimAxisOptions {
  double encoder_resolution = 0;  // rad
  double repeatability = 0;       // rad, standard deviation of where a move truly ends
  double reference = 0;           // rad, where the reference mark is, inside the limits
  Seconds home_limit{120};        // homing that takes longer is kTimeout
};

// Moves a SimMotor. The motor ends a little off its target (repeatability) and the encoder reads
// where it truly is, rounded. Homing runs at a quarter of the speed.
class SimAxis final : public Axis {
 public:
  SimAxis(std::string name, const AxisLimits& limits, const SimAxisOptions& options,
          std::shared_ptr<SimMotor> motor, Clock& clock, Random random);
  ~SimAxis() override;

  const std::string& name() const override { return name_; }
  const AxisLimits& limits() const override { return limits_; }
  const std::string& identity() const override { return identity_; }
  Result<AxisState> State() override;
  Result<void> Home(std::stop_token stop) override;
  Result<Seconds> StartMove(double position) override;
  Result<void> WaitUntilStill(Seconds limit, std::stop_token stop) override;
  Result<void> Stop() override;
  Result<void> EmergencyStop() override { return Stop(); }

  // Draws from `random` from now on.
  void Reseed(Random random) { random_ = random; }

  // Faults. Any thread.
  void PullPlug();   // the link is gone; the motor brakes
  void LosePower();  // the motor brakes and the position is forgotten

 private:
  double Encoder() const;
  Result<void> CheckLink() const;
  Error Fail(ErrorCode code, const std::string& what) const;
  Result<void> SleepThroughMove(Seconds limit, const char* operation, std::stop_token stop);

  const std::string name_;
  const std::string identity_ = "simulated";
  const AxisLimits limits_;
  const SimAxisOptions options_;
  const std::shared_ptr<SimMotor> motor_;
  Clock& clock_;
  Random random_;
  mutable std::mutex mutex_;  // guards the rest
  bool homed_ = false;
  bool connected_ = true;
  double target_ = 0;  // rad, of the last move
  double zero_ = 0;    // rad, the true position that the encoder calls zero
};

}  // namespace gonio
