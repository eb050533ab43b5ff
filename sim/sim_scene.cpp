// SPDX-License-Identifier: Apache-2.0
#include "sim/sim_scene.h"

#include <algorithm>
#include <utility>

namespace gonio {

SimArms operator+(const SimArms& a, const SimArms& b) {
  return {a[0] + b[0], a[1] + b[1], a[2] + b[2], a[3] + b[3]};
}

MotorScene::MotorScene(SimMotors motors, std::shared_ptr<const SimLamp> lamp, const SimArms& offset)
    : motors_(std::move(motors)), lamp_(std::move(lamp)), offset_(offset) {}

SimArms MotorScene::ArmsAt(Seconds time) const {
  SimArms arms{};
  for (std::size_t i = 0; i < arms.size(); ++i) {
    if (motors_[i]) arms[i] = motors_[i]->PositionAt(time);
  }
  return arms + offset_;
}

bool MotorScene::MovingBetween(Seconds begin, Seconds end) const {
  return std::any_of(motors_.begin(), motors_.end(),
                     [&](const auto& motor) { return motor && motor->MovingBetween(begin, end); });
}

Result<void> ReadbackScene::Look() {
  for (std::size_t i = 0; i < arms_.size(); ++i) {
    if (axes_[i] == nullptr) continue;
    const Result<AxisState> state = axes_[i]->State();
    if (!state) return state.error();
    if (state->moving) {
      return Error{ErrorCode::kProtocol, axes_[i]->name() + ": moves while the shutter is open"};
    }
    arms_[i] = state->position;
  }
  arms_ = arms_ + offset_;
  const Result<double> level = light_->Level();
  if (!level) return level.error();
  power_ = *level;
  if (!light_->has_colours()) return {};
  const auto colour = light_->Selected();
  if (!colour) return colour.error();
  spectrum_ = SpectrumOf(*colour, crosstalk_);
  return {};
}

}  // namespace gonio
