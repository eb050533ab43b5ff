// SPDX-License-Identifier: Apache-2.0
#include "drivers/apt_stages.h"

#include <fmt/format.h>

#include "drivers/wire_text.h"

namespace gonio::apt {
namespace {

constexpr double kSteps = 409600.0;              // of a stepper motor's turn, at 2048 a full step
constexpr double kStepVelocity = 53.68;          // of K10CR1, HDR50, NR360, per step/s
constexpr double kStepAcceleration = 204.94e-6;  // per unit of velocity
constexpr double kWorm = 75091 / 0.99997;        // steps per degree of HDR50, NR360
constexpr double kCrown = kSteps / 3;            // steps per degree of K10CR1

constexpr Stage kStages[] = {
    // KDC101, and TDC001, which it replaced.
    {"PRM1-Z8", true, 1919.64, 42941.66, 14.66, {27, 83}},
    // KBD101, TBD001, BBD10x and BBD20x, BBD30x.
    {"DDR100", true, 3276800 / 360.0, 61083.98, 6.255, {28, 67, 73, 103}},
    {"DDR05", true, 2000000 / 360.0, 37282.7, 3.818, {28, 67, 73, 103}},
    // Its controller is inside.
    {"K10CR1",
     false,
     kCrown,
     kCrown* kStepVelocity,
     kCrown* kStepVelocity* kStepAcceleration,
     {55}},
    // BSC201 and BSC203; their forerunners have the same numbers and other steps.
    {"HDR50", false, kWorm, 4030885 / 0.99997, 826 / 0.99997, {40, 70}},
    {"NR360", false, kWorm, 4030885 / 0.99997, 826 / 0.99997, {40, 70}},
};

std::string Beginnings(const Stage& stage) {
  std::string text;
  for (const int serial : stage.serials) {
    if (serial != 0) text += fmt::format("{}{}", text.empty() ? "" : ", ", serial);
  }
  return text;
}

bool Begins(const std::string& text, std::string_view beginning) {
  return std::string_view(text).substr(0, beginning.size()) == beginning;
}

}  // namespace

Result<Stage> FindStage(std::string_view name) {
  std::string known;
  for (const Stage& stage : kStages) {
    if (stage.name == name) return stage;
    known += fmt::format("{}{}", known.empty() ? "" : ", ", stage.name);
  }
  return Error{ErrorCode::kRefused,
               fmt::format("{} is no stage known here; known are {}", Quoted(name), known)};
}

std::string WhyNotDriven(const Stage& stage, const Info& controller) {
  const std::string who =
      fmt::format("{} with serial number {}", controller.model, controller.serial);
  if (!stage.servo && (Begins(controller.model, "BSC10") || Begins(controller.model, "SCC10"))) {
    return fmt::format("{} makes other steps than a BSC20x, for which the scale of a {} is known",
                       who, stage.name);
  }
  if (controller.serial <= 0) return {};
  for (const int beginning : stage.serials) {
    // Behind the beginning there are six digits.
    if (beginning != 0 && controller.serial / 1'000'000 == beginning) return {};
  }
  return fmt::format("{} does not drive a {}: the number would begin with one of {}", who,
                     stage.name, Beginnings(stage));
}

}  // namespace gonio::apt
