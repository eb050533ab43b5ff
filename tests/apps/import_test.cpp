// SPDX-License-Identifier: Apache-2.0
// gonio import, and every command on what it leaves; raw frames as files.

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <vector>

#include "acquisition/radiometry/frame_file.h"
#include "acquisition/session_frames.h"
#include "acquisition/session_record.h"
#include "brdf/analytic.h"
#include "brdf/samples_csv.h"
#include "core/sha256.h"
#include "core/units.h"
#include "tests/apps/gonio_process.h"

namespace gonio {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

class Import : public GonioTest {
 protected:
  // Readings of a satin coating less 0.004, as if too much background had been taken off: a fifth
  // of them are negative. Four incidences in the plane and across it.
  void WriteRt300s(const std::string& name = "scan.csv") {
    const AnalyticBrdf sample{"satin", {Ggx{.roughness = 0.25, .f0 = Rgb::Constant(0.04)}}};
    std::string text = "clock,azimuth_deg,incidence_deg,receive_deg,RT\n";
    int second = 0;
    for (const double azimuth : {-90.0, -45.0, 0.0}) {
      for (const double incidence : {10.0, 30.0, 50.0, 70.0}) {
        for (double receive = -80; receive <= 80; receive += 10) {
          const DirectionPair pair{FromSpherical(RadFromDeg(incidence), 0),
                                   FromSpherical(RadFromDeg(receive), RadFromDeg(90 - azimuth))};
          const double f_r = sample.Eval(pair).value_or(Rgb::Zero())[1];
          text +=
              fmt::format("2024-05-01T12:{:02}:{:02},{},{},{},{:.6g}\n", second / 60, second % 60,
                          azimuth, incidence, receive, f_r * pair.cos_theta_o() - 0.004);
          second += 2;
        }
      }
    }
    File(name, text);
  }
  SessionRecord Session() { return ReadSession(work() / "s"); }
  std::string Page() { return ReadTextFile(work() / "s/report.html"); }
};

TEST_F(Import, KeepsReadingsTimesAndTheFileItself) {
  WriteRt300s();
  const Finished finished = Expect("import scan.csv --out s");
  EXPECT_THAT(finished.out, HasSubstr("204 samples as rt300s"));
  const SessionRecord session = Session();
  const std::string bytes = ReadTextFile(work() / "scan.csv");
  EXPECT_EQ(ReadTextFile(work() / "s/imported/scan.csv"), bytes);
  EXPECT_EQ(session.info.imported.at("sha256"), Sha256(bytes));
  EXPECT_EQ(session.info.imported.at("started"), "2024-05-01T12:00:00");
  EXPECT_EQ(session.info.imported.at("raw_frames"), "none");
  ASSERT_EQ(session.poses.size(), 204u);
  EXPECT_EQ(session.poses[1].end, Seconds(2));
  EXPECT_EQ(session.poses[1].frames, 0);
  ASSERT_TRUE(session.end.has_value());
  EXPECT_EQ(session.end->outcome, "complete");
  EXPECT_EQ(session.end->duration, Seconds(406));
  const auto read = ParseSamplesCsv("theta_i_deg,theta_o_deg,phi_deg,f_r\n10,-80,180,1\n", "one");
  EXPECT_LT((session.poses[0].samples[0].directions.wo - read[0].sample.directions.wo).norm(),
            1e-12);
  const std::vector<BrdfSample> samples = session.Samples();
  EXPECT_GT(std::count_if(samples.begin(), samples.end(),
                          [](const BrdfSample& sample) { return sample.f_r[0] < 0; }),
            20);
}

// In the receiver's shadow a reading is of the receiver, whatever it says.
TEST_F(Import, KeepsShadowedReadingsOutOfFits) {
  WriteRt300s();
  EXPECT_THAT(Expect("import scan.csv --out s").out, HasSubstr("shadowed         4 samples"));
  int unusable = 0;
  for (const MeasuredPose& pose : Session().poses) {
    const BrdfSample& sample = pose.samples[0];
    if (std::isfinite(sample.sigma[0])) continue;
    ++unusable;
    EXPECT_LT(AngleBetween(sample.directions.wi, sample.directions.wo), RadFromDeg(5.5));
    EXPECT_NE(sample.f_r[0], 0);
  }
  EXPECT_EQ(unusable, 4);
  EXPECT_THAT(Expect("import scan.csv --out all --min-separation-deg 0").out,
              Not(HasSubstr("shadowed")));
}

TEST_F(Import, IsASessionToEveryOtherCommand) {
  WriteRt300s();
  Expect("import scan.csv --out s");
  EXPECT_THAT(Expect("fit s --out fit.yaml").out, HasSubstr("at its own samples"));
  Expect("export s --to csv samples.csv");
  EXPECT_EQ(ReadSamplesCsv(work() / "samples.csv").size(), 204u);
  EXPECT_THAT(ReadTextFile(work() / "samples.csv"), HasSubstr("file: scan.csv"));
  EXPECT_THAT(Expect("compare samples.csv fit.yaml").out, HasSubstr("528 compared, 84 left out"));
  Expect("plot s --out slice.svg");
  Expect("export s --to merl table.binary");
  Expect("report s");
  const std::string page = Page();
  for (const char* word : {"Imported from", "scan.csv", "Readings as they came", "below zero",
                           "zero or below", "RT / cos(receive_deg)", "by its clock"}) {
    EXPECT_NE(page.find(word), std::string::npos) << word;
  }
  for (const char* word : {"dense scan", "within reach", ">nan", "saturated", "Rig file"}) {
    EXPECT_EQ(page.find(word), std::string::npos) << word;
  }
  // Made again from the same samples, bit for bit, by way of a CSV.
  Expect("import samples.csv --out again");
  const std::vector<BrdfSample> a = Session().Samples();
  const std::vector<BrdfSample> b = ReadSession(work() / "again").Samples();
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i) EXPECT_TRUE((a[i].f_r == b[i].f_r).all());
}

TEST_F(Import, IsReplayedFromTheFileItKeeps) {
  WriteRt300s();
  Expect("import scan.csv --out s");
  EXPECT_THAT(Expect("replay s --refit").out,
              AllOf(HasSubstr("none of ours: imported from scan.csv"),
                    HasSubstr("read again       204 samples, 204 as they were to the last bit"),
                    HasSubstr("MALE")));
  ExpectRefused(Gonio("replay s --rereduce"), 2, {"it has no raw frames"});
  ExpectRefused(Gonio("replay s --plan plan-grid.yaml"), 2, {"--rig names one to measure it on"});
  const std::string other = Expect("replay s --plan plan-random.yaml --rig sim-rig.yaml").out;
  EXPECT_THAT(other, AllOf(HasSubstr("plan random"), HasSubstr("read what the session read")));
  // Somebody has had their hands on it.
  File("s/imported/scan.csv", ReadTextFile(work() / "s/imported/scan.csv") + "# \n");
  const Finished changed = Gonio("replay s");
  EXPECT_EQ(changed.code, 1);
  EXPECT_THAT(changed.out, HasSubstr("is not the file that was imported"));
}

TEST_F(Import, TakesRowsOfOnePoseForItsParts) {
  File("s.csv",
       "pose,theta_i_deg,theta_o_deg,phi_deg,f_r,time_s\n"
       "7,10,20,90,1,3\n7,10,21,90,2,3\n9,10,22,90,3,5\n7,10,23,90,4,6\n");
  Expect("import s.csv --out s");
  const SessionRecord session = Session();
  ASSERT_EQ(session.poses.size(), 3u);
  EXPECT_EQ(session.poses[0].samples.size(), 2u);
  EXPECT_EQ(session.poses[2].pose, 3);
  EXPECT_EQ(session.poses[2].samples[0].f_r[0], 4);
}

TEST_F(Import, ReadsCornellFilesInTheBandsThatAreAskedFor) {
  File("m.brdf", "# Card\n3\n450 550 650\n0.5 0 0.5 3.1 0.1 -0.2 0.4\n0.5 0 0.6 3.1 0.1 0.2 0.4\n");
  Expect("import m.brdf --out s --bands-nm 640-660,540-560,440-460");
  const SessionRecord session = Session();
  EXPECT_TRUE((session.poses[0].samples[0].f_r == Rgb(0.4, -0.2, 0.1)).all());
  EXPECT_EQ(session.info.imported.at("title"), "Card");
  ExpectRefused(Gonio("import m.brdf --out t --bands-nm 1-2,3"), 2, {"--bands-nm: must be like"});
  ExpectRefused(Gonio("import m.brdf --out t --bands-nm 800-900,1-2,1-2"), 2,
                {"m.brdf: has no wavelength from 800 to 900 nm"});
  ExpectRefused(Gonio("import m.brdf --out t --format csv"), 2, {"m.brdf:2: column theta_i_deg"});
  EXPECT_EQ(Files(), (std::vector<std::string>{"m.brdf", "s"}));
}

TEST_F(Import, RefusesWhatItCannotReadAndLeavesNothing) {
  WriteRt300s();
  std::filesystem::create_directory(work() / "s");
  ExpectRefused(Gonio("import scan.csv --out s"), 2, {"s: exists already"});
  File("bad.csv", "clock,azimuth_deg,incidence_deg,receive_deg,RT\n2024-05-01T12:00:00,0,1,x,1\n");
  ExpectRefused(Gonio("import bad.csv --out t"), 2, {"bad.csv:2: column receive_deg: is \"x\""});
  ExpectRefused(Gonio("import no.csv --out t"), 2, {"no.csv: cannot read"});
  File("m.txt", "");
  ExpectRefused(Gonio("import m.txt --out t"), 2, {"must be .csv or .brdf; or name a --format"});
  ExpectRefused(Gonio("import scan.csv --out no/t"), 2, {"no/t: cannot make this directory"});
  ExpectRefused(Gonio("import scan.csv --out t --bands-nm 1-2,1-2,1-2"), 2,
                {"only a cornell file"});
  EXPECT_FALSE(std::filesystem::exists(work() / "t"));
}

// Example failure is a TIFF with bytes swapped, or frames of an unfinished pose left out.
TEST_F(Import, HasItsOppositeForRawFrames) {
  Expect("run --quiet --out s --max-poses 3");
  Expect("export s --frames frames");
  SessionFrames frames(work() / "s");
  int files = 0;
  for (int pose = 1; pose <= 3; ++pose) {
    int number = 0;
    for (const Exposure& exposure : frames.Of(pose)) {
      const Frame& frame = exposure.frame;
      SensorFormat format;
      format.width = frame.width;
      format.height = frame.height;
      format.layout = frame.layout;
      const auto stored = ReadFrameFile(
          work() / fmt::format("frames/pose-{:04}/frame-{:02}.yaml", pose, ++number), format);
      ASSERT_TRUE(stored.has_value()) << pose << " " << number;
      EXPECT_EQ(stored->frame.counts, frame.counts);
      EXPECT_EQ(stored->frame.exposure, frame.exposure);
      EXPECT_EQ(stored->frame.black_level, frame.black_level);
      EXPECT_EQ(stored->frame.start, frame.start);
      EXPECT_EQ(stored->monitor, exposure.monitor);
      ++files;
    }
  }
  EXPECT_GE(files, 3);
  ExpectRefused(Gonio("export s --frames frames"), 2, {"frames: exists already"});
  ExpectRefused(Gonio("export s"), 2, {"needs --to or --frames"});
  ExpectRefused(Gonio("export s --to csv"), 2, {"belong together"});
  WriteRt300s();
  Expect("import scan.csv --out imported");
  ExpectRefused(Gonio("export imported --frames none"), 2, {"imported: holds no raw frame"});
  EXPECT_FALSE(std::filesystem::exists(work() / "none"));
}

}  // namespace
}  // namespace gonio
