// SPDX-License-Identifier: Apache-2.0
// A folder of calibrations is used for the camera it is of, while it is fresh enough, or not at
// all.

#include "acquisition/calibration/calibrations.h"

#include <gmock/gmock.h>

#include "acquisition/calibration/calibration_status.h"
#include "core/file.h"
#include "tests/calibration/imperfect_rig.h"

namespace gonio {
namespace {

namespace fs = std::filesystem;

using testing::HasSubstr;

std::string Refusal(const CalibrationPolicy& policy, const SensorFormat& format,
                    std::int64_t now = kToday) {
  try {
    (void)LoadCalibrations(policy, format, now);
  } catch (const ConfigError& e) {
    return e.what();
  }
  return "none";
}

CalibrationPolicy PolicyOf(const fs::path& folder) {
  CalibrationPolicy policy;
  policy.folder = folder;
  return policy;
}

TEST(Calibrations, AreReadWithTheirAges) {
  const Calibrations found = LoadFrom(CalibratedFolder());
  EXPECT_TRUE(found.dark && found.sensor && found.bad_pixels && found.flat && found.stray &&
              found.responsivity);
  EXPECT_EQ(AgesOf(found, kToday + 86400).substr(0, 13), "dark 1.0 days");
}

TEST(Calibrations, OfAnotherCameraAreRefused) {
  SensorFormat other = ImperfectFormat();
  other.camera = "serial 2";
  EXPECT_THAT(Refusal(PolicyOf(CalibratedFolder()), other),
              testing::AllOf(HasSubstr("dark.yaml"), HasSubstr("camera is serial 2")));
  SensorFormat moved = ImperfectFormat();
  moved.left = 8;
  EXPECT_THAT(Refusal(PolicyOf(CalibratedFolder()), moved), HasSubstr("left is 8"));
  SensorFormat louder = ImperfectFormat();
  louder.gain_db = 6;
  EXPECT_THAT(Refusal(PolicyOf(CalibratedFolder()), louder), HasSubstr("gain in dB is 6"));
}

TEST(Calibrations, ThatAreOldAreSaidOrRefused) {
  CalibrationPolicy policy = PolicyOf(CalibratedFolder());
  policy.max_age = 86400;
  const std::int64_t later = kToday + 3 * 86400;
  EXPECT_EQ(Refusal(policy, ImperfectFormat(), later), "none");
  const Calibrations found = LoadCalibrations(policy, ImperfectFormat(), later);
  ASSERT_EQ(OldOnes(found, policy, later).size(), found.files.size());
  EXPECT_THAT(OldOnes(found, policy, later).front(), HasSubstr("gonio calibrate darks"));
  policy.refuse_old = true;
  EXPECT_THAT(Refusal(policy, ImperfectFormat(), later), HasSubstr("is 3.0 days old"));
  EXPECT_THAT(Refusal(policy, ImperfectFormat(), kToday - 10), HasSubstr("future"));
}

TEST(Calibrations, ThatAreMissingAreNamedWithTheirCommand) {
  const TempDir dir;
  CalibrationPolicy policy = PolicyOf(dir.path());
  policy.required = {CalibrationKind::kFlatField};
  EXPECT_THAT(Refusal(policy, ImperfectFormat()), HasSubstr("gonio calibrate flat"));
  EXPECT_THAT(Refusal(PolicyOf(dir.path() / "nowhere"), ImperfectFormat()),
              HasSubstr("no such folder"));
}

// Copies are whole; one flipped byte in an image is seen.
TEST(Calibrations, AreCopiedAndRefusedWhenDamaged) {
  const TempDir dir;
  CopyCalibrations(LoadFrom(CalibratedFolder()), dir.path() / "copy");
  const Calibrations copy = LoadFrom(dir.path() / "copy");
  ASSERT_EQ(copy.files.size(), 6u);
  EXPECT_EQ(copy.files[0].sha256, LoadFrom(CalibratedFolder()).files[0].sha256);
  const fs::path image = copy.files[0].images.front();
  std::string bytes = ReadTextFile(image);
  bytes[bytes.size() / 2] ^= 1;
  WriteFileAtomically(image, [&](std::ostream& out) { out << bytes; });
  EXPECT_THAT(Refusal(PolicyOf(dir.path() / "copy"), ImperfectFormat()), HasSubstr("was changed"));
  const auto status = StatusOf(PolicyOf(dir.path() / "copy"), kToday);
  EXPECT_THAT(status[0].problem, HasSubstr("was changed"));
  EXPECT_THAT(status[1].numbers, HasSubstr("e/count"));
}

TEST(CalibrationPolicy, IsReadFromTheRig) {
  const ConfigNode node = ConfigNode::Parse(
      "folder: cal\nmax_age_days: 2\nwhen_old: refuse\nrequired: [dark, flat-field]\n",
      "/rigs/a.yaml");
  const CalibrationPolicy policy = ReadCalibrationPolicy(node);
  node.RefuseUnknownKeys();
  EXPECT_EQ(policy.folder, "/rigs/cal");
  EXPECT_EQ(policy.max_age, 2 * 86400);
  EXPECT_TRUE(policy.refuse_old);
  ASSERT_EQ(policy.required.size(), 2u);
  EXPECT_EQ(policy.required[1], CalibrationKind::kFlatField);
  EXPECT_THROW(ReadCalibrationPolicy(ConfigNode::Parse("folder: a\nrequired: [flats]\n", "a.yaml")),
               ConfigError);
}

}  // namespace
}  // namespace gonio
