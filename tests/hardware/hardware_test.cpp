// SPDX-License-Identifier: Apache-2.0
// What drivers promise, asked of the devices of the rig file that GONIO_HARDWARE_RIG names: one
// after the other, in real time. Axes are homed and move over their whole range.
#include <gtest/gtest.h>

#include <cstdlib>
#include <memory>
#include <stdexcept>
#include <string>

#include "apps/gonio/build_rig.h"
#include "tests/conformance/axis.h"
#include "tests/conformance/light.h"
#include "tests/conformance/monitor.h"

namespace gonio {
namespace {

constexpr const char* kNoRig =
    "GONIO_HARDWARE_RIG names no rig file; with it, this moves and lights the machine itself";

// The rig under test; null without the variable. Throws ConfigError, which fails the test.
const RigConfig* Rig() {
  static const std::unique_ptr<const RigConfig> rig = []() -> std::unique_ptr<const RigConfig> {
    const char* const path = std::getenv("GONIO_HARDWARE_RIG");
    if (path == nullptr || *path == '\0') return nullptr;
    RigConfig config = LoadRig(path).config;
    if (config.simulated) throw ConfigError(std::string(path) + ": kind: is not real");
    return std::make_unique<const RigConfig>(std::move(config));
  }();
  return rig.get();
}

const std::shared_ptr<SystemClock>& RealTime() {
  static const auto clock = std::make_shared<SystemClock>();
  return clock;
}

template <typename Device>
std::unique_ptr<Device> Opened(Result<std::unique_ptr<Device>> device) {
  if (!device) throw std::runtime_error(device.error().message);
  return std::move(device).value();
}

std::unique_ptr<Axis> OpenAxis(int index) {
  AxisOpener opener(RealTime().get(), std::make_shared<LinkLog>(RealTime().get()));
  return Opened(OpenRealAxis(*Rig(), index, opener));
}

AxisSubject SubjectOf(int index) {
  AxisSubject subject;
  if (Rig() == nullptr) {
    subject.absent = kNoRig;
    return subject;
  }
  if (index >= Rig()->axis_count) {
    subject.absent = "the rig has fewer axes";
    return subject;
  }
  subject.clock = RealTime();
  subject.axis = OpenAxis(index);
  subject.open_again = [index] { return OpenAxis(index); };
  subject.noise = Rig()->axes[index].position_tolerance;
  return subject;
}

INSTANTIATE_TEST_SUITE_P(LightAzimuth, AxisConformance,
                         testing::Values([] { return SubjectOf(kLightAzimuth); }));
INSTANTIATE_TEST_SUITE_P(LightElevation, AxisConformance,
                         testing::Values([] { return SubjectOf(kLightElevation); }));
INSTANTIATE_TEST_SUITE_P(CameraAzimuth, AxisConformance,
                         testing::Values([] { return SubjectOf(kCameraAzimuth); }));
INSTANTIATE_TEST_SUITE_P(CameraElevation, AxisConformance,
                         testing::Values([] { return SubjectOf(kCameraElevation); }));

// The one judges the other: an LED's light grows a little slower than its current, and a room is
// not quite dark.
constexpr double kNonlinearity = 0.1;
constexpr double kStray = 0.02;

std::string WhyNoLight() {
  if (Rig() == nullptr) return kNoRig;
  if (Rig()->light_device.driver == LightDevice::Driver::kSimulated) return "it is simulated";
  return "";
}

std::unique_ptr<Light> OpenRigLight() {
  return Opened(
      OpenLight(Rig()->light_device, "light", std::make_shared<LinkLog>(RealTime().get())));
}
std::unique_ptr<Monitor> OpenRigMonitor() {
  return Opened(
      OpenMonitor(Rig()->monitor_device, "monitor", std::make_shared<LinkLog>(RealTime().get())));
}

double ReadOrThrow(Monitor& monitor) {
  const auto reading = monitor.Read();
  if (!reading) throw std::runtime_error(reading.error().message);
  return *reading;
}

LightSubject RigLight() {
  LightSubject subject;
  subject.absent = WhyNoLight();
  if (!subject.absent.empty()) return subject;
  const std::shared_ptr<Monitor> monitor = OpenRigMonitor();
  subject.light = OpenRigLight();
  // One monitor cannot tell colours apart: it judges that with which each test begins.
  if (subject.light->has_colours()) {
    const auto selected = subject.light->Select(LightColour::kGreen, {});
    if (!selected) throw std::runtime_error(selected.error().message);
    const auto told = monitor->Expect(LightColour::kGreen);
    if (!told) throw std::runtime_error(told.error().message);
  }
  if (auto lit = subject.light->SetLevel(1); !lit) throw std::runtime_error(lit.error().message);
  const double full = ReadOrThrow(*monitor);
  subject.emitted = [monitor, full] { return ReadOrThrow(*monitor) / full; };
  subject.nonlinearity = kNonlinearity;
  subject.stray = kStray;
  return subject;
}

MonitorSubject RigMonitor() {
  MonitorSubject subject;
  subject.absent = WhyNoLight();
  if (!subject.absent.empty()) return subject;
  const std::shared_ptr<Light> light = OpenRigLight();
  subject.shine = [light](double power) {
    if (auto lit = light->SetLevel(power); !lit) throw std::runtime_error(lit.error().message);
  };
  subject.noise = kNonlinearity / 3;
  subject.stray = kStray;
  subject.brightest = 1;
  subject.monitor = OpenRigMonitor();
  return subject;
}

INSTANTIATE_TEST_SUITE_P(Rig, LightConformance, testing::Values(RigLight));
INSTANTIATE_TEST_SUITE_P(Rig, MonitorConformance, testing::Values(RigMonitor));

}  // namespace
}  // namespace gonio
