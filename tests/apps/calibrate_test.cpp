// SPDX-License-Identifier: Apache-2.0
// gonio calibrate and the sessions that use its files, as a user runs them.

#include <gmock/gmock.h>

#include <cmath>
#include <fstream>

#include "acquisition/session_record.h"
#include "core/sha256.h"
#include "core/units.h"
#include "tests/apps/gonio_process.h"

namespace gonio {
namespace {

namespace fs = std::filesystem;

using testing::HasSubstr;

class CalibrateTest : public GonioTest {
 protected:
  // All files into cal/, made once for the whole program and copied.
  void Calibrated() {
    static const TempDir made;
    static const bool once = [&] {
      for (const char* step : {"darks", "photon-transfer", "flat", "stray-light"}) {
        Expect(fmt::format("calibrate {} --rig sim-imperfect.yaml --out cal --quiet", step));
      }
      const Finished last = Expect(
          "calibrate standard --rig sim-imperfect.yaml --out cal --standard standard-ptfe.yaml");
      EXPECT_THAT(last.out, HasSubstr("electrons/s/(1/sr)"));
      fs::copy(work() / "cal", made.path() / "cal", fs::copy_options::recursive);
      fs::remove_all(work() / "cal");
      return true;
    }();
    ASSERT_TRUE(once);
    fs::copy(made.path() / "cal", work() / "cal", fs::copy_options::recursive);
  }
  void Edit(const std::string& file, const std::string& from, const std::string& to) {
    const std::string text = ReadTextFile(work() / file);
    File(file, With(text, from, to));
  }
  Finished Run(const std::string& more) {
    return Gonio(
        "run --rig sim-imperfect.yaml --plan plan-grid.yaml --max-poses 12 --quiet "
        "--material ptfe.yaml --out session " +
        more);
  }
  // Mean of f_r / truth - 1 over all poses and colours.
  double Bias() {
    const SessionRecord record = ReadSession(work() / "session");
    double sum = 0;
    double n = 0;
    for (const BrdfSample& sample : record.Samples()) {
      for (int c = 0; c < kChannels; ++c) {
        sum += sample.f_r[c] / (0.98 / kPi) - 1;
        n += 1;
      }
    }
    return sum / n;
  }
};

// Of a lens before the same camera: other sessions of its folder keep their background.
TEST_F(CalibrateTest, FindsTheGlareOfALens) {
  Calibrated();
  EXPECT_THAT(Gonio("calibrate glare --rig sim-imperfect.yaml --out cal").err,
              HasSubstr("without `imaging`"));
  File("lens.yaml", With(Config("sim-imperfect.yaml"), "exposure:\n",
                         "imaging: {focal_length_px: 2000, camera_distance_mm: 500, "
                         "light_distance_mm: 800, patch_radius_mm: 2}\n\nexposure:\n") +
                        "  veiling_glare: 0.03\n");
  const Finished glare = Expect("calibrate glare --rig lens.yaml --out cal --trap-radius-mm 1.8");
  EXPECT_THAT(glare.out, testing::AllOf(HasSubstr("a black trap in a white tile"),
                                        HasSubstr("% of the image's mean")));
  const ConfigNode stray = ConfigNode::Load(work() / "cal/stray-light.yaml").Map("estimates");
  for (const char* colour : {"red", "green", "blue"}) {
    const auto g = stray.Numbers(std::string(colour) + "_glare", 2);
    EXPECT_NEAR(g[0], 0.03 / 1.03, 3.5 * g[1]) << colour;
    EXPECT_LT(g[1], 0.004) << colour;
  }
}

TEST_F(CalibrateTest, SaysWhatTheReferenceDid) {
  File("drift.yaml",
       With(Config("sim-imperfect.yaml"), "exposure:\n", "drift: {every_poses: 4}\n\nexposure:\n"));
  const Finished run = Gonio(
      "run --rig drift.yaml --plan plan-grid.yaml --max-poses 12 --quiet --material ptfe.yaml "
      "--out session");
  ASSERT_EQ(run.code, 0) << run.err;
  EXPECT_THAT(run.out, HasSubstr("reference        3 visits; the gain is now "));
  EXPECT_EQ(ReadSession(work() / "session").poses.size(), 12u);
}

// A session from end to end. Example failure: files that are checked, copied, and not used.
TEST_F(CalibrateTest, MakesSessionsTrue) {
  Calibrated();
  EXPECT_THAT(Expect("calibrate status --rig sim-imperfect.yaml --out cal").out,
              testing::AllOf(HasSubstr("32 x 32 px"), HasSubstr("flat-field       0.0 days"),
                             HasSubstr("e/s/(1/sr) by simulated white tile")));
  const Finished run = Run("--calibration cal");
  ASSERT_EQ(run.code, 0) << run.err;
  EXPECT_THAT(run.out, HasSubstr("dark 0.0 days, photon-transfer 0.0 days, bad-pixels"));
  const double bias = Bias();
  const SessionRecord record = ReadSession(work() / "session");
  double stated = 0;  // of the mean: nearly all of it is what the samples share
  for (const MeasuredPose& pose : record.poses) {
    ASSERT_EQ(pose.systematic.size(), pose.samples.size());
    stated += pose.systematic[0].mean() / (0.98 / kPi) / static_cast<double>(record.poses.size());
  }
  EXPECT_GT(stated, 0.004);
  EXPECT_LT(std::abs(bias), 3 * stated);

  // What was used lies in the session, by its digest.
  ASSERT_EQ(record.info.calibrations.size(), 6u);
  for (const auto& [file, sha256] : record.info.calibrations) {
    EXPECT_EQ(Sha256OfFile(work() / "session/calibration" / file), sha256) << file;
  }

  fs::rename(work() / "session", work() / "calibrated");
  ASSERT_EQ(Run("").code, 0);
  EXPECT_GT(std::abs(Bias()), 5 * stated);
  EXPECT_TRUE(ReadSession(work() / "session").info.calibrations.empty());
}

TEST_F(CalibrateTest, IsRefusedForAnotherCamera) {
  Calibrated();
  Edit("cal/dark.yaml", "camera: \"simulated\"", "camera: \"other\"");
  ExpectRefused(Run("--calibration cal"), 2, {"dark.yaml", "calibrated for other"});
  EXPECT_FALSE(fs::exists(work() / "session"));
}

TEST_F(CalibrateTest, IsRefusedWhenDamaged) {
  Calibrated();
  Edit("cal/responsivity.yaml", "version: 1", "version: 7");
  ExpectRefused(Run("--calibration cal"), 2, {"responsivity.yaml", "version"});
  Edit("cal/responsivity.yaml", "version: 7", "version: 1");
  for (const auto& entry : fs::directory_iterator(work() / "cal")) {
    if (entry.path().filename().string().starts_with("flat-field.response")) {
      std::ofstream(entry.path(), std::ios::app) << "x";
    }
  }
  ExpectRefused(Run("--calibration cal"), 2, {"flat-field.yaml", "was changed"});
}

TEST_F(CalibrateTest, IsSaidOrRefusedWhenOld) {
  Calibrated();
  const std::string text = ReadTextFile(work() / "cal/stray-light.yaml");
  const auto at = text.find("created_utc: \"") + 14;
  Edit("cal/stray-light.yaml", text.substr(at, 20), "2019-05-01T10:00:00Z");
  const Finished warned = Run("--calibration cal");
  EXPECT_EQ(warned.code, 0);
  EXPECT_THAT(warned.err, testing::AllOf(HasSubstr("gonio: warning: "), HasSubstr("stray-light"),
                                         HasSubstr("gonio calibrate stray-light")));
  fs::remove_all(work() / "session");
  File("strict.yaml", Config("sim-imperfect.yaml") +
                          "\ncalibration: {folder: cal, when_old: refuse, required: [dark]}\n");
  ExpectRefused(Gonio("run --rig strict.yaml --out session"), 2,
                {"stray-light.yaml", "days old", "max_age_days"});
  fs::remove(work() / "cal/dark.yaml");
  ExpectRefused(Gonio("run --rig strict.yaml --out session"), 2,
                {"dark.yaml", "gonio calibrate darks"});
}

// Example failure is a file that is used whatever its age because the camera has no part in it.
TEST_F(CalibrateTest, TimesGrowOldToo) {
  Expect("run --max-poses 20 --out first --quiet");
  Expect("calibrate time first --out cal/time.yaml");
  const std::string run = "run --max-poses 2 --quiet --calibration cal --out ";
  EXPECT_THAT(Expect(run + "second").out, HasSubstr("calibration      time 0.0 days"));
  const std::string text = ReadTextFile(work() / "cal/time.yaml");
  const auto at = text.find("created_utc: \"") + 14;
  Edit("cal/time.yaml", text.substr(at, 20), "2019-05-01T10:00:00Z");
  EXPECT_THAT(Gonio(run + "third").err,
              testing::AllOf(HasSubstr("gonio: warning: "), HasSubstr("days old"),
                             HasSubstr("gonio calibrate time renews it")));
  File("strict.yaml", Config("sim-rig.yaml") + "\ncalibration: {folder: cal, when_old: refuse}\n");
  ExpectRefused(Gonio("run --rig strict.yaml --out fourth"), 2, {"time.yaml", "days old"});
}

TEST_F(CalibrateTest, SaysWhichStepIsMissing) {
  ExpectRefused(Gonio("calibrate flat --rig sim-imperfect.yaml --out cal"), 2,
                {"dark.yaml", "gonio calibrate darks"});
  ExpectRefused(Gonio("calibrate darks"), 2, {"--out"});
  ExpectRefused(Gonio("run --calibration nowhere --out session"), 2, {"nowhere"});
}

}  // namespace
}  // namespace gonio
