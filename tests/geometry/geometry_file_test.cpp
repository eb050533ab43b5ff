// SPDX-License-Identifier: Apache-2.0
#include "acquisition/geometry_calibration/geometry_file.h"

#include <gtest/gtest.h>

#include "core/error.h"
#include "tests/core/temp_dir.h"
#include "tests/geometry/planted.h"

namespace gonio {
namespace {

GeometryFit SomeFit(bool has_light) {
  GeometryFit fit;
  const auto planted = PlantedValues(PlantedTruth());
  for (int i = 0; i < kGeometryUnknowns; ++i) fit.unknowns[i] = {planted[i], 1e-4 * (i + 1)};
  fit.has_light = has_light;
  fit.board_views = 9;
  return fit;
}

SensorFormat SomeCamera() { return {.camera = "some camera", .width = 640, .height = 480}; }

TEST(GeometryFile, ReadsWhatWasWrittenAndIsUsed) {
  const TempDir dir;
  const auto path = dir.path() / kGeometryFile;
  WriteGeometry(path, SomeFit(true), SomeCamera(), 1000);
  const GeometryFit fit = ReadGeometry(path, SomeCamera(), 2000);
  RigConfig rig = BelievedRig();
  UseGeometry(fit, rig);
  EXPECT_DOUBLE_EQ(rig.imaging.focal_length, 3060);
  EXPECT_DOUBLE_EQ(rig.imaging.light_distance, 0.585);
  for (int i = 0; i < kAxes; ++i) {
    EXPECT_NEAR(rig.axis_offsets[i], PlantedTruth().axis_offset[i], 1e-12);
  }
  ASSERT_TRUE(rig.sigma_of_directions);
  EXPECT_NEAR(*rig.sigma_of_directions, 1e-4 * (kLightElevationOffset + 1), 1e-12);
}

// Without a mirror the light stays as the rig file has it.
TEST(GeometryFile, LeavesTheLightAloneWithoutAMirror) {
  const TempDir dir;
  const auto path = dir.path() / kGeometryFile;
  WriteGeometry(path, SomeFit(false), SomeCamera(), 1000);
  RigConfig rig = BelievedRig();
  UseGeometry(ReadGeometry(path, SomeCamera(), 2000), rig);
  EXPECT_DOUBLE_EQ(rig.imaging.light_distance, 0.6);
  EXPECT_EQ(rig.axis_offsets[kLightAzimuth], 0);
}

TEST(GeometryFile, RefusesAnotherCamera) {
  const TempDir dir;
  const auto path = dir.path() / kGeometryFile;
  WriteGeometry(path, SomeFit(true), SomeCamera(), 1000);
  SensorFormat other = SomeCamera();
  other.camera = "another";
  EXPECT_THROW(ReadGeometry(path, other, 2000), ConfigError);
}

}  // namespace
}  // namespace gonio
