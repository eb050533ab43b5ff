// SPDX-License-Identifier: Apache-2.0
#include "sim/sim_imager.h"

#include <gtest/gtest.h>

#include "core/units.h"
#include "tests/brdf/function_brdf.h"

namespace gonio {
namespace {

const FunctionBrdf kGrey([](const HalfDiff&) { return Rgb(Rgb::Constant(0.5)); });
const FunctionBrdf kWhite([](const HalfDiff&) { return Rgb(Rgb::Constant(1)); });

SimView View() {
  return {.arms = {0, RadFromDeg(30), kPi, RadFromDeg(60)},
          .power = 1,
          .readout = {.exposure = Seconds(2), .layout = PixelLayout::kMono}};
}

SimConfig Truth() {
  SimConfig truth;
  truth.responsivity = Rgb::Constant(1000);
  return truth;
}

// 1000 /s * f_r * cos 60 deg * 2 s, whether there is an image or not.
TEST(SimImager, CountsWhatTheMeasurementEquationSays) {
  for (const double focal_length : {0.0, 1000.0}) {
    const Imaging imaging = {
        .focal_length = focal_length, .camera_distance = 0.5, .light_distance = 0.5, .shape = {}};
    SimImager imager(Truth(), imaging, 31, 21, Random(1, 1));
    const std::size_t middle = 10 * 31 + 15;
    SimView view = View();
    EXPECT_EQ(imager.Expose(view, kGrey).counts.at(middle), 500);
    EXPECT_EQ(imager.Expose(view, kWhite).counts.at(middle), 1000);
    view.power = 0.5;
    EXPECT_EQ(imager.Expose(view, kWhite).counts.at(middle), 500);
    view.power = 0;
    view.readout.black_level = 7;
    EXPECT_EQ(imager.Expose(view, kWhite).counts, std::vector<std::uint16_t>(31 * 21, 7));
  }
}

TEST(SimImager, ReadsRegionsOfTheSameScene) {
  const Imaging imaging = {
      .focal_length = 50, .camera_distance = 0.5, .light_distance = 0.5, .shape = {}};
  SimConfig truth = Truth();
  truth.every_px = 1;
  truth.prnu = 0.1;
  SimImager imager(truth, imaging, 40, 30, Random(1, 1));
  SimView view = View();
  const Frame whole = imager.Expose(view, kGrey);
  view.readout.region = {.x = 20, .y = 10, .width = 8, .height = 6};
  const Frame part = imager.Expose(view, kGrey);
  EXPECT_EQ(part.width, 8);
  for (int i = 0; i < 48; ++i) {
    EXPECT_EQ(part.counts.at(i), whole.counts.at((10 + i / 8) * 40 + 20 + i % 8));
  }
}

}  // namespace
}  // namespace gonio
