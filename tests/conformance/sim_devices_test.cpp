// SPDX-License-Identifier: Apache-2.0
// The simulated devices keep the promises of drivers/.
#include "sim/sim_axis.h"
#include "sim/sim_rig.h"
#include "tests/brdf/function_brdf.h"
#include "tests/conformance/axis.h"
#include "tests/conformance/camera.h"
#include "tests/conformance/light.h"
#include "tests/conformance/monitor.h"

namespace gonio {
namespace {

const FunctionBrdf kGrey([](const HalfDiff&) { return Rgb(Rgb::Constant(0.3)); });

AxisSubject SimAxisSubject(const SimAxisOptions& options) {
  const AxisLimits limits = {.min_position = -3,
                             .max_position = 2,
                             .max_speed = 0.35,
                             .acceleration = 0.7,
                             .position_tolerance = 1e-3};
  AxisSubject subject;
  subject.clock = std::make_shared<ManualClock>();
  auto motor =
      std::make_shared<SimMotor>(-1, limits.max_speed, limits.acceleration, *subject.clock);
  auto axis =
      std::make_unique<SimAxis>("axis", limits, options, motor, *subject.clock, Random(1, 0));
  subject.shaft = [motor] { return motor->Position(); };
  subject.pull_plug = [axis = axis.get()] { axis->PullPlug(); };
  subject.axis = std::move(axis);
  return subject;
}

AxisSubject IdealAxis() { return SimAxisSubject({}); }
AxisSubject ImperfectAxis() {
  return SimAxisSubject({.encoder_resolution = 3.5e-5, .repeatability = 1e-4, .reference = -3});
}

CameraSubject SimCameraSubject(SimConfig truth, PixelLayout layout, const Imaging& imaging) {
  truth.shot_noise = true;
  truth.read_noise = 8;
  truth.multiplicative_noise = 0.01;
  truth.responsivity = Rgb::Constant(1e5);
  const CameraInfo info = {.width = 5,
                           .height = 3,
                           .layout = layout,
                           .min_exposure = Seconds(20e-6),
                           .max_exposure = Seconds(10),
                           .readout = Seconds(0.03)};
  CameraSubject subject;
  subject.clock = std::make_shared<ManualClock>();
  auto lamp = std::make_shared<SimLamp>(0);
  lamp->set_level(1);
  SimMotors motors;
  for (auto& motor : motors) motor = std::make_shared<SimMotor>(0.8, 1, 1, *subject.clock);
  subject.camera = std::make_unique<SimCamera>("camera", info, truth, kGrey,
                                               std::make_unique<MotorScene>(motors, lamp),
                                               *subject.clock, Random(1, 0), imaging);
  return subject;
}

CameraSubject NoisyCamera() { return SimCameraSubject({}, PixelLayout::kRgb, {}); }
CameraSubject ImagingCamera() {
  SimConfig truth;
  truth.prnu = 0.01;
  truth.defocus = 1;
  return SimCameraSubject(
      truth, PixelLayout::kBayerGr,
      {.focal_length = 100, .camera_distance = 0.5, .light_distance = 0.5, .shape = {}});
}

LightSubject DriftingLight() {
  auto lamp = std::make_shared<SimLamp>(0.01);
  LightSubject subject;
  subject.light = std::make_unique<SimLight>("light", lamp);
  subject.emitted = [lamp] { return lamp->PowerAt(Seconds(0)); };
  subject.turn_by_hand = [lamp](double level) { lamp->set_level(level); };
  return subject;
}

LightSubject ThreeLeds() {
  LightSubject subject = DriftingLight();
  auto lamp = std::make_shared<SimLamp>(0);
  lamp->GiveColours(0);
  subject.light = std::make_unique<SimLight>("light", lamp);
  subject.emitted = [lamp] { return lamp->PowerAt(Seconds(0)); };
  subject.turn_by_hand = [lamp](double level) { lamp->set_level(level); };
  subject.emitted_in = [lamp](LightColour colour) {
    const double band = lamp->SpectrumAt(Seconds(0))[static_cast<int>(colour)] / kChannels;
    return lamp->PowerAt(Seconds(0)) * band;
  };
  return subject;
}

LightSubject WheelBeforeALamp() {
  SimSetup setup;
  for (AxisLimits& axis : setup.axes) axis = {0, 1, 1, 1, 0.01};
  setup.wheel = SimWheel{.limits = {-1, 5, 1, 2, 1e-3}, .filters = {.positions = {0, 2, 4}}};
  const auto clock = std::make_shared<ManualClock>();
  SimDevices devices = MakeSimDevices({}, setup, kGrey, *clock, 1);
  LightSubject subject;
  subject.emitted = [lamp = devices.lamp, clock] { return lamp->PowerAt(clock->Now()); };
  subject.turn_by_hand = [lamp = devices.lamp](double level) { lamp->set_level(level); };
  subject.emitted_in = [lamp = devices.lamp, clock](LightColour colour) {
    const double band = lamp->SpectrumAt(clock->Now())[static_cast<int>(colour)] / kChannels;
    return lamp->PowerAt(clock->Now()) * band;
  };
  subject.light = std::move(devices.light);
  return subject;
}

MonitorSubject NoisyMonitor() {
  const auto clock = std::make_shared<ManualClock>();
  auto lamp = std::make_shared<SimLamp>(0);
  MonitorSubject subject;
  subject.noise = 1e-3;
  subject.monitor =
      std::make_unique<SimMonitor>("monitor", lamp, subject.noise, *clock, Random(1, 0));
  // Which keeps the clock, too.
  subject.shine = [lamp, clock](double power) { lamp->set_level(power); };
  return subject;
}

INSTANTIATE_TEST_SUITE_P(SimIdeal, AxisConformance, testing::Values(IdealAxis));
INSTANTIATE_TEST_SUITE_P(SimImperfect, AxisConformance, testing::Values(ImperfectAxis));
INSTANTIATE_TEST_SUITE_P(Sim, CameraConformance, testing::Values(NoisyCamera));
INSTANTIATE_TEST_SUITE_P(SimImaging, CameraConformance, testing::Values(ImagingCamera));
INSTANTIATE_TEST_SUITE_P(Sim, LightConformance, testing::Values(DriftingLight));
INSTANTIATE_TEST_SUITE_P(SimLeds, LightConformance, testing::Values(ThreeLeds));
INSTANTIATE_TEST_SUITE_P(SimWheel, LightConformance, testing::Values(WheelBeforeALamp));
INSTANTIATE_TEST_SUITE_P(Sim, MonitorConformance, testing::Values(NoisyMonitor));

}  // namespace
}  // namespace gonio
