// SPDX-License-Identifier: Apache-2.0
// An emulated board with Grbl and what its axes are opened with in tests.

#pragma once

#include <gtest/gtest.h>

#include <atomic>
#include <memory>
#include <string>
#include <utility>

#include "drivers/grbl_axis.h"
#include "sim/grbl_emulator.h"
#include "tests/drivers/wire_axis.h"

namespace gonio::grbl {

class GrblTest : public testing::Test {
 protected:
  void SwitchOn(const GrblBoard& settings = {}) {
    machine_.reset();
    line_.reset();
    board_ = std::make_unique<GrblEmulator>(settings, clock_);
    line_ = std::make_unique<PtyServer>(
        [this](std::string_view bytes) {
          const std::string answer = board_->Receive(bytes);
          const bool jog = bytes.find("$J") != std::string_view::npos;
          return jog && garble_jogs_ ? "oj\r\n" : answer;
        },
        [this] { return board_->Unasked(); });
  }
  Result<std::shared_ptr<Machine>> OpenMachine(const Machine::Times& times = {
                                                   .reply = kWireReplyLimit, .boot = Seconds(5)}) {
    auto port = OpenedPort(*line_);
    board_->Reset();  // as opening its port does
    return Machine::Open(std::move(port), clock_.get(), times);
  }
  static ControllerAxisSettings Settings(const std::string& name = "arm") {
    ControllerAxisSettings settings = ArmSettings();
    settings.name = name;
    settings.scale.zero = 2.6;
    return settings;
  }
  Result<std::unique_ptr<Axis>> Open(char letter, const ControllerAxisSettings& settings) {
    if (!machine_) {
      auto machine = OpenMachine();
      if (!machine) return machine.error();
      machine_ = *machine;
    }
    return OpenAxis(machine_, letter, settings, clock_.get());
  }
  std::string WhyNot(const ControllerAxisSettings& settings, char letter = 'X') {
    const auto axis = Open(letter, settings);
    return axis.ok() ? "opened" : axis.error().message;
  }
  std::string WhyNotBoard(const GrblBoard& settings) {
    SwitchOn(settings);
    return WhyNot(Settings());
  }
  std::unique_ptr<Axis> Opened(char letter, const std::string& name = "arm") {
    auto axis = Open(letter, Settings(name));
    EXPECT_TRUE(axis.ok()) << axis.error().message;
    return std::move(axis).value();
  }
  std::unique_ptr<Axis> Homed() {
    SwitchOn();
    auto axis = Opened('X');
    EXPECT_TRUE(axis->Home({}).ok());
    return axis;
  }
  // What is wrong with the end of a move that was started.
  static std::string WhyNotThere(Axis& axis) {
    const auto still = axis.WaitUntilStill(Seconds(60), {});
    return still.ok() ? "there" : still.error().message;
  }
  double Angle(int axis) const { return 2.6 + board_->Shaft(axis); }

  const std::shared_ptr<ManualClock> clock_ = std::make_shared<ManualClock>();
  std::unique_ptr<GrblEmulator> board_;
  std::atomic<bool> garble_jogs_ = false;
  std::unique_ptr<PtyServer> line_;
  std::shared_ptr<Machine> machine_;
};

}  // namespace gonio::grbl
