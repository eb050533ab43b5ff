// SPDX-License-Identifier: Apache-2.0
#include "acquisition/motion.h"

#include <fmt/format.h>

#include <cmath>
#include <numeric>
#include <string>
#include <vector>

#include "core/check.h"
#include "core/units.h"
#include "drivers/move_time.h"

namespace gonio {
namespace {

// How long a move may take: half as long again as it should, and two seconds for the controller.
Seconds TimeLimit(Seconds expected) { return 1.5 * expected + Seconds(2); }

// Starts `axes` together and waits for each. An axis that ran out of time, or came to rest beside
// its target, counts as arrived: the read-back will tell.
Result<void> MoveLeg(Devices& devices, const std::vector<int>& axes, const AxisPositions& target,
                     std::stop_token stop) {
  AxisPositions expected{};  // s
  for (const int i : axes) {
    const auto started = devices.axes[i]->StartMove(target[i]);
    if (!started) return started.error();
    expected[i] = started->count();
  }
  for (const int i : axes) {
    const auto still = devices.axes[i]->WaitUntilStill(TimeLimit(Seconds(expected[i])), stop);
    if (!still && still.error().code != ErrorCode::kTimeout) return still;
  }
  return {};
}

// By way of turning points where an axis has to come from the other side.
Result<void> MoveOnce(const RigConfig& rig, Devices& devices, const std::vector<int>& axes,
                      const AxisPositions& from, const AxisPositions& target,
                      std::stop_token stop) {
  AxisPositions first = target;
  std::vector<int> turning;
  for (const int i : axes) {
    const auto turn = TurningPoint(from[i], target[i], rig.axes[i]);
    if (!turn) continue;
    first[i] = *turn;
    turning.push_back(i);
  }
  if (auto moved = MoveLeg(devices, axes, first, stop); !moved) return moved;
  return MoveLeg(devices, turning, target, stop);
}

Result<Arrival> MoveWithRetries(const RigConfig& rig, Devices& devices, Clock& clock,
                                const AxisPositions& target, Seconds settle, std::stop_token stop) {
  std::vector<int> missed(static_cast<std::size_t>(rig.axis_count));
  std::iota(missed.begin(), missed.end(), 0);
  Arrival arrival;
  auto position = ReadPositions(devices);
  for (int attempt = 0;; ++attempt) {
    if (!position) return position.error();
    if (attempt == 0) {
      std::erase_if(missed, [&](int i) { return Stays((*position)[i] - target[i], rig.axes[i]); });
    }
    if (auto moved = MoveOnce(rig, devices, missed, *position, target, stop); !moved) {
      return moved.error();
    }
    arrival.still = clock.Now();
    arrival.retries = attempt;
    clock.SleepFor(settle, stop);
    if (stop.stop_requested()) return Error{ErrorCode::kCancelled, "settling: cancelled"};
    position = ReadPositions(devices);
    if (!position) return position.error();
    arrival.readback = *position;
    std::erase_if(missed, [&](int i) {
      return std::abs((*position)[i] - target[i]) <= rig.axes[i].position_tolerance;
    });
    if (missed.empty()) return arrival;
    if (attempt == rig.motion.retries) break;
  }
  const int i = missed.front();
  return Error{
      ErrorCode::kRefused,
      fmt::format("{}: stands at {:.4f} deg after {} moves to {:.4f} deg, tolerance {} deg",
                  devices.axes[i]->name(), DegFromRad((*position)[i]), rig.motion.retries + 1,
                  DegFromRad(target[i]), DegFromRad(rig.axes[i].position_tolerance))};
}

// The first error, but all are told.
template <typename Tell>
Result<void> ForAll(Devices& devices, const Tell& tell) {
  Result<void> first;
  for (auto& axis : devices.axes) {
    if (!axis) continue;
    auto told = tell(*axis);
    if (first.ok() && !told.ok()) first = std::move(told);
  }
  return first;
}

}  // namespace

Result<AxisPositions> ReadPositions(Devices& devices) {
  AxisPositions position{};
  for (int i = 0; i < kAxes; ++i) {
    if (devices.axes[i] == nullptr) continue;
    const auto state = devices.axes[i]->State();
    if (!state) return state.error();
    if (!state->homed) {
      return Error{ErrorCode::kProtocol,
                   devices.axes[i]->name() + ": has lost its reference, home it again"};
    }
    position[i] = state->position;
  }
  return position;
}

Result<void> HomeAll(const MotionConfig& motion, Devices& devices, std::stop_token stop) {
  for (const int i : motion.home_order) {
    if (auto homed = devices.axes[i]->Home(stop); !homed) {
      (void)StopAll(devices);
      return homed;
    }
  }
  return {};
}

Result<Arrival> MoveAll(const RigConfig& rig, Devices& devices, Clock& clock,
                        const AxisPositions& target, std::stop_token stop) {
  return MoveAlong(rig, devices, clock, {&target, 1}, stop);
}

Result<Arrival> MoveAlong(const RigConfig& rig, Devices& devices, Clock& clock,
                          std::span<const AxisPositions> legs, std::stop_token stop) {
  GONIO_CHECK(!legs.empty(), "a way without a target");
  Arrival arrival;
  for (std::size_t i = 0; i < legs.size(); ++i) {
    const Seconds settle = i + 1 == legs.size() ? rig.motion.settle : Seconds(0);
    auto leg = MoveWithRetries(rig, devices, clock, legs[i], settle, stop);
    if (!leg) {
      // The first error is the one to report; stopping may fail for the same reason.
      (void)StopAll(devices);
      return leg;
    }
    leg->retries += arrival.retries;
    arrival = *leg;
  }
  return arrival;
}

Result<void> StopAll(Devices& devices) {
  return ForAll(devices, [](Axis& axis) { return axis.Stop(); });
}

Result<void> EmergencyStopAll(Devices& devices) {
  return ForAll(devices, [](Axis& axis) { return axis.EmergencyStop(); });
}

}  // namespace gonio
