// SPDX-License-Identifier: Apache-2.0
// A rotary stage of Zaber's, on a chain that speaks ASCII.

#pragma once

#include <memory>
#include <string>

#include "drivers/axis.h"
#include "drivers/zaber_chain.h"

namespace gonio::zaber {

struct AxisSettings {
  std::string name;     // in every error message
  int device = 1;       // 1 .. 99
  int axis = 1;         // 1 .. 9
  AxisLimits limits;    // of the mechanism; inside the controller's own
  double zero = 0;      // rad: the mechanism's angle where the controller reads 0
  bool turned = false;  // the mechanism turns the other way
  Seconds home_limit{120};
};

// Steps per turn come from the controller (limit.cycle.dist), so a stage cannot be driven at
// another one's scale. At opening its speed and acceleration are set to the limits and read back.
//
// An axis that has lost its reference (warnings WR, WH: after power-up, a reset, a stall) is not
// homed until Home() says so; it is asked before every move.
class ZaberAxis final : public Axis {
 public:
  // kRefused: no such axis, not a rotary one, limits outside the controller's, a speed it cannot
  // have. Moves nothing. `chain` may be shared with other axes; `clock` outlives the axis.
  static Result<std::unique_ptr<ZaberAxis>> Open(std::shared_ptr<Chain> chain,
                                                 const AxisSettings& settings, Clock* clock);
  ~ZaberAxis() override;

  const std::string& name() const override { return settings_.name; }
  const AxisLimits& limits() const override { return settings_.limits; }
  Result<AxisState> State() override;
  Result<void> Home(std::stop_token stop) override;
  Result<void> StartMove(double position) override;
  Result<void> WaitUntilStill(Seconds limit, std::stop_token stop) override;
  Result<void> Stop() override;

 private:
  ZaberAxis(std::shared_ptr<Chain> chain, const AxisSettings& settings, Clock* clock);

  Result<void> ReadScaleAndLimits();
  Result<void> SetSpeed();
  Result<double> Setting(const std::string& setting);
  Result<double> NumberOf(const Message& reply, const std::string& setting) const;
  Result<void> Set(const std::string& setting, double value);
  Result<Message> Ask(const std::string& query);
  Result<Message> Tell(const std::string& command);
  // Until the controller says IDLE, or a reason why not; then it has been stopped.
  Result<Message> WaitForIdle(Seconds limit, std::stop_token stop, const char* doing);
  Result<void> CheckArrival();

  double ToSteps(double position) const;
  double ToPosition(double steps) const;
  Error Fail(ErrorCode code, const std::string& what) const;

  const std::shared_ptr<Chain> chain_;
  const AxisSettings settings_;
  Clock* const clock_;
  double steps_per_radian_ = 0;
  double target_ = 0;  // rad, of the last move
};

}  // namespace gonio::zaber
