// SPDX-License-Identifier: Apache-2.0
#include "sim/sim_rig.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "core/units.h"
#include "tests/brdf/function_brdf.h"

namespace gonio {
namespace {

const FunctionBrdf kGrey([](const HalfDiff&) { return Rgb(Rgb::Constant(0.3)); });

SimSetup SmallRig() {
  SimSetup setup;
  for (AxisLimits& axis : setup.axes) {
    axis = {.min_position = RadFromDeg(2),
            .max_position = RadFromDeg(90),
            .max_speed = 1,
            .acceleration = 1,
            .position_tolerance = 0.01};
  }
  setup.camera = {
      .width = 4, .height = 4, .min_exposure = Seconds(1e-5), .max_exposure = Seconds(10)};
  return setup;
}

SimConfig Noisy() {
  SimConfig truth;
  truth.repeatability = 0.001;
  truth.monitor_noise = 0.01;
  truth.multiplicative_noise = 0.01;
  truth.read_noise = 5;
  truth.shot_noise = true;
  truth.black_level = 100;
  truth.responsivity = Rgb::Constant(10000);
  return truth;
}

// A short session; everything that can be read.
std::vector<double> Journal(std::uint64_t seed, bool read_monitor = true) {
  ManualClock clock;
  SimDevices devices = MakeSimDevices(Noisy(), SmallRig(), kGrey, clock, seed);
  std::vector<double> journal;
  EXPECT_TRUE(devices.light->SetLevel(1).ok());
  for (auto& axis : devices.axes) {
    EXPECT_TRUE(axis->Home({}).ok());
    EXPECT_TRUE(axis->StartMove(0.6).ok());
    EXPECT_TRUE(axis->WaitUntilStill(Seconds(60), {}).ok());
    journal.push_back(axis->State()->position);
  }
  if (read_monitor) journal.push_back(*devices.monitor->Read());
  const Frame frame = devices.camera->Capture(Seconds(0.1), {}).value();
  journal.insert(journal.end(), frame.counts.begin(), frame.counts.end());
  return journal;
}

TEST(MakeSimDevices, SameSeedSameCounts) {
  EXPECT_EQ(Journal(1), Journal(1));
  EXPECT_NE(Journal(1), Journal(2));
}

// What a rig without an image has counted since its first version: recorded sessions stay
// repeatable. Example failure is a new imperfection that draws a random number while it is off.
TEST(MakeSimDevices, CountsAsEver) {
  const std::vector<double> journal = Journal(1);
  ASSERT_EQ(journal.size(), 5 + 4 * 4 * 3);
  const std::vector<double> counts(journal.begin() + 5, journal.begin() + 11);
  EXPECT_EQ(counts, (std::vector<double>{274, 262, 288, 264, 271, 261}));
}

TEST(MakeSimDevices, OneDevicesNoiseDoesNotDependOnAnothersUse) {
  std::vector<double> with = Journal(3);
  with.erase(with.begin() + 4);  // the monitor's reading
  EXPECT_EQ(with, Journal(3, false));
}

TEST(MakeSimDevices, StartsDarkAndNotHomed) {
  ManualClock clock;
  SimDevices devices = MakeSimDevices(Noisy(), SmallRig(), kGrey, clock, 1);
  EXPECT_EQ(*devices.light->Level(), 0);
  for (auto& axis : devices.axes) EXPECT_FALSE(axis->State()->homed);
  EXPECT_EQ(devices.axes[2]->name(), "camera_azimuth");
}

// Example failure is an offset of the wrong sign, or one that the encoders tell.
TEST(MakeSimDevices, ArmsStandBesideWhereTheirEncodersSay) {
  SimConfig truth;
  truth.responsivity = Rgb::Constant(1000);
  truth.axis_offset = {0, RadFromDeg(30), 0, 0};
  SimSetup setup = SmallRig();
  setup.camera.layout = PixelLayout::kMono;
  setup.imaging = {.focal_length = 1e5, .camera_distance = 1, .light_distance = 1, .shape = {}};
  setup.gain_db = 20;
  ManualClock clock;
  SimDevices devices = MakeSimDevices(truth, setup, kGrey, clock, 1);
  ASSERT_TRUE(devices.light->SetLevel(1).ok());
  for (auto& axis : devices.axes) {
    ASSERT_TRUE(axis->Home({}).ok());
    ASSERT_TRUE(axis->StartMove(RadFromDeg(30)).ok());
    ASSERT_TRUE(axis->WaitUntilStill(Seconds(60), {}).ok());
  }
  const Frame frame = devices.camera->Capture(Seconds(1), {}).value();
  ASSERT_EQ(frame.counts.size(), 16);
  EXPECT_NEAR(frame.counts[5], 1000 * 0.3 * std::sin(RadFromDeg(60)) * 10, 1);
  EXPECT_EQ(frame.gain_db, 20);
  EXPECT_NEAR(devices.axes[1]->State()->position, RadFromDeg(30), 0.001);
}

TEST(MakeSimDevices, HomesTheArmsApart) {
  ManualClock clock;
  SimDevices devices = MakeSimDevices(Noisy(), SmallRig(), kGrey, clock, 1);
  for (auto& axis : devices.axes) ASSERT_TRUE(axis->Home({}).ok());
  EXPECT_GT(devices.motors[3]->Position() - devices.motors[1]->Position(), 1.5);
}

}  // namespace
}  // namespace gonio
