// SPDX-License-Identifier: Apache-2.0
#include "brdf/samples_csv.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "core/error.h"
#include "core/file.h"
#include "core/units.h"
#include "tests/core/temp_dir.h"

namespace gonio {
namespace {

using testing::StartsWith;

constexpr double kInfinity = std::numeric_limits<double>::infinity();
const std::string kHeader =
    "theta_i_deg,phi_i_deg,theta_o_deg,phi_o_deg,f_r_red,f_r_green,f_r_blue\n";

std::vector<MeasuredSample> Parse(const std::string& text) {
  return ParseSamplesCsv(text, "s.csv");
}

std::vector<MeasuredSample> Samples() {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> unit(0, 1);
  std::vector<MeasuredSample> samples(50);
  for (int i = 0; i < 50; ++i) {
    MeasuredSample& m = samples[i];
    m.pose = i / 2;
    m.time_s = 1000 * unit(random);
    m.sample.directions = {FromSpherical(1.55 * unit(random), 7 * unit(random) - 3),
                           FromSpherical(1.55 * unit(random), 7 * unit(random) - 3)};
    for (int c = 0; c < kChannels; ++c) {
      m.sample.f_r[c] = unit(random) - 0.1;
      m.sample.sigma[c] = 1e-3 * unit(random) + 1e-9;
    }
  }
  samples[0].sample.directions = {};  // both along the normal
  samples[1].sample.f_r[1] = -1e-7;
  samples[2].sample.sigma[2] = kInfinity;
  return samples;
}

TEST(SamplesCsv, ReadsBackEveryNumberExactlyAndDirectionsToRounding) {
  const TempDir dir;
  const auto written = Samples();
  WriteSamplesCsv(dir / "s.csv", written, {"satin paint", "seed 7"});
  const auto read = ReadSamplesCsv(dir / "s.csv");
  ASSERT_EQ(read.size(), written.size());
  for (std::size_t i = 0; i < read.size(); ++i) {
    EXPECT_EQ(read[i].pose, written[i].pose);
    EXPECT_EQ(read[i].time_s, written[i].time_s);
    EXPECT_TRUE((read[i].sample.f_r == written[i].sample.f_r).all());
    EXPECT_TRUE((read[i].sample.sigma == written[i].sample.sigma).all());
    const DirectionPair &a = read[i].sample.directions, &b = written[i].sample.directions;
    EXPECT_LT((a.wi - b.wi).norm() + (a.wo - b.wo).norm(), 1e-14);
  }
}

TEST(SamplesCsv, StartsWithTheCommentsAndTheDocumentedHeader) {
  const TempDir dir;
  WriteSamplesCsv(dir / "s.csv", Samples(), {"satin paint"});
  EXPECT_THAT(ReadTextFile(dir / "s.csv"),
              StartsWith("# satin paint\n"
                         "pose,theta_i_deg,phi_i_deg,theta_o_deg,phi_o_deg,theta_h_deg,theta_d_deg,"
                         "phi_d_deg,f_r_red,f_r_green,f_r_blue,sigma_red,sigma_green,sigma_blue,"
                         "time_s\n"));
}

TEST(SamplesCsv, WritesZeroForAnUnusableChannel) {
  const TempDir dir;
  std::vector<MeasuredSample> samples(1);
  samples[0].sample.f_r = Rgb(0.1, std::nan(""), 0.3);
  samples[0].sample.sigma = Rgb(0.01, kInfinity, 0.01);
  WriteSamplesCsv(dir / "s.csv", samples);
  const auto read = ReadSamplesCsv(dir / "s.csv");
  EXPECT_EQ(read[0].sample.f_r[1], 0);
  EXPECT_EQ(read[0].sample.sigma[1], kInfinity);
}

TEST(SamplesCsv, ReadsColumnsInAnyOrderAndIgnoresOthers) {
  const auto samples = Parse(
      "f_r_blue,operator,f_r_red,theta_o_deg,phi_o_deg,theta_i_deg,phi_i_deg,f_r_green\n"
      "0.3,Ann,0.1,60,90,30,0,0.2\n");
  ASSERT_EQ(samples.size(), 1u);
  EXPECT_TRUE((samples[0].sample.f_r == Rgb(0.1, 0.2, 0.3)).all());
  EXPECT_NEAR(samples[0].sample.directions.cos_theta_i(), std::cos(RadFromDeg(30)), 1e-15);
  EXPECT_NEAR(samples[0].sample.directions.wo.y(), std::sin(RadFromDeg(60)), 1e-15);
}

TEST(SamplesCsv, FillsInWhatIsOptional) {
  const auto samples = Parse(kHeader + "30,0,40,180,0.5,-0.25,0\n10,0,40,180,1,1,1\n");
  ASSERT_EQ(samples.size(), 2u);
  EXPECT_EQ(samples[0].pose, 0);
  EXPECT_EQ(samples[1].pose, 1);
  EXPECT_EQ(samples[1].time_s, 0);
  EXPECT_EQ(samples[0].sample.f_r[1], -0.25);
  EXPECT_DOUBLE_EQ(samples[0].sample.sigma[0], 0.02 * 0.5 + 1e-4);
  EXPECT_DOUBLE_EQ(samples[0].sample.sigma[1], 0.02 * 0.25 + 1e-4);
  EXPECT_DOUBLE_EQ(samples[0].sample.sigma[2], 1e-4);
}

TEST(SamplesCsv, TakesSigmaOfTheChannelsThatHaveIt) {
  const auto samples = Parse(
      "theta_i_deg,phi_i_deg,theta_o_deg,phi_o_deg,f_r_red,f_r_green,f_r_blue,sigma_green\n"
      "30,0,40,180,1,1,1,inf\n");
  EXPECT_EQ(samples[0].sample.sigma[1], kInfinity);
  EXPECT_DOUBLE_EQ(samples[0].sample.sigma[2], 0.0201);
}

TEST(SamplesCsv, PutsUpWithWhatSpreadsheetsDo) {
  const auto samples = Parse(
      "\xEF\xBB\xBF# saved by a spreadsheet\r\n\r\n"
      "\"theta_i_deg\", \"phi_i_deg\",theta_o_deg,phi_o_deg ,f_r_red,f_r_green,f_r_blue\r\n"
      "30 ,0, 40,180,+0.1,2E-1,\"0.3\"\r\n# in between\r\n  \r\n10,0,40,180,1,1,1");
  ASSERT_EQ(samples.size(), 2u);
  EXPECT_TRUE((samples[0].sample.f_r == Rgb(0.1, 0.2, 0.3)).all());
}

double PolarDeg(const Eigen::Vector3d& w) { return DegFromRad(std::acos(w.z())); }

// An arm in the plane of incidence passes the normal: -20 is 20 on the side of phi + 180.
TEST(SamplesCsv, TakesANegativePolarAngleForTheOtherSide) {
  const auto samples = Parse(kHeader + "30,0,-20,0,1,1,1\n30,0,20,180,1,1,1\n");
  EXPECT_LT((samples[0].sample.directions.wo - samples[1].sample.directions.wo).norm(), 1e-15);
  EXPECT_LT(samples[0].sample.directions.wo.x(), 0);
}

// Example failure is phi counted from the detector, or 0 taken for the mirror's side.
TEST(SamplesCsv, ReadsOneAzimuthBetweenLightAndDetectorAndOneChannel) {
  const auto samples = Parse("theta_i_deg,theta_o_deg,phi_deg,f_r,sigma\n30,40,0,-0.5,0.1\n");
  const BrdfSample& sample = samples[0].sample;
  EXPECT_NEAR(DegFromRad(AngleBetween(sample.directions.wi, sample.directions.wo)), 10, 1e-9);
  EXPECT_TRUE((sample.f_r == -0.5).all());
  EXPECT_TRUE((sample.sigma == 0.1).all());
}

TEST(SamplesCsv, ReadsHalfAnglesWhereThereAreNoOthers) {
  const auto samples = Parse("theta_h_deg,theta_d_deg,phi_d_deg,f_r\n20,35,75,1\n");
  const HalfDiff angles = ToHalfDiff(samples[0].sample.directions);
  EXPECT_NEAR(DegFromRad(angles.theta_h), 20, 1e-9);
  EXPECT_NEAR(DegFromRad(angles.theta_d), 35, 1e-9);
  EXPECT_NEAR(DegFromRad(angles.phi_d), 75, 1e-9);
}

TEST(SamplesCsv, ReadsRadians) {
  const auto samples = Parse("theta_i_rad,theta_o_rad,phi_rad,f_r\n0.5,1.5,3,1\n");
  EXPECT_NEAR(PolarDeg(samples[0].sample.directions.wi), DegFromRad(0.5), 1e-9);
  EXPECT_NEAR(PolarDeg(samples[0].sample.directions.wo), DegFromRad(1.5), 1e-9);
}

TEST(SamplesCsv, KeepsRowsWithTheSameDirectionsApart) {
  const auto samples = Parse(kHeader + "30,0,40,180,1,1,1\n30,0,40,180,2,2,2\n");
  ASSERT_EQ(samples.size(), 2u);
  EXPECT_EQ(samples[1].sample.f_r[0], 2);
}

struct BadCsv {
  const char* label;
  std::string text;
  const char* complaint;
};

void PrintTo(const BadCsv& bad, std::ostream* out) { *out << bad.label; }

class BadSamplesCsv : public testing::TestWithParam<BadCsv> {};

TEST_P(BadSamplesCsv, IsRefusedWithItsLine) {
  EXPECT_EQ(MessageOf<ConfigError>([] { Parse(GetParam().text); }), GetParam().complaint);
}

const std::string kWithSigma =
    "pose,theta_i_deg,phi_i_deg,theta_o_deg,phi_o_deg,f_r_red,f_r_green,f_r_blue,sigma_red,time_"
    "s\n";

INSTANTIATE_TEST_SUITE_P(
    SamplesCsv, BadSamplesCsv,
    testing::Values(
        BadCsv{"Empty", "", "s.csv: holds no header row"},
        BadCsv{"OnlyComments", "# a\n\n# b\n", "s.csv: holds no header row"},
        BadCsv{"OnlyAHeader", kHeader, "s.csv: holds no samples"},
        BadCsv{"NoHeader", "30,0,40,180,1,1,1\n", "s.csv:1: column theta_i_deg is missing"},
        BadCsv{"MissingColumn",
               "# a\ntheta_i_deg,phi_i_deg,theta_o_deg,phi_o_deg,f_r_red,f_r_blue\n1,1,1,1,1,1\n",
               "s.csv:2: column f_r_green is missing"},
        BadCsv{"RepeatedColumn", "theta_i_deg," + kHeader,
               "s.csv:1: column theta_i_deg stands twice"},
        BadCsv{"ShortRow", kHeader + "30,0,40,180,1,1\n", "s.csv:2: has 6 cells, the header has 7"},
        BadCsv{"LongRow", kHeader + "30,0,40,180,1,1,1\n30,0,40,180,1,1,1,\n",
               "s.csv:3: has 8 cells, the header has 7"},
        BadCsv{"Words", kHeader + "abc,0,40,180,1,1,1\n",
               "s.csv:2: column theta_i_deg: is \"abc\", must be a finite number"},
        BadCsv{"TrailingWords", kHeader + "30,0,40,180,1,1 W,1\n",
               "s.csv:2: column f_r_green: is \"1 W\", must be a finite number"},
        BadCsv{"EmptyCell", kHeader + "30,0,40,180,1,,1\n",
               "s.csv:2: column f_r_green: is \"\", must be a finite number"},
        BadCsv{"NaN", kHeader + "30,0,40,180,1,1,nan\n",
               "s.csv:2: column f_r_blue: is \"nan\", must be a finite number"},
        BadCsv{"InfiniteAngle", kHeader + "30,inf,40,180,1,1,1\n",
               "s.csv:2: column phi_i_deg: is \"inf\", must be a finite number"},
        BadCsv{
            "BelowTheHorizon", kHeader + "30,0,90,180,1,1,1\n",
            "s.csv:2: column theta_o_deg: is \"90\", must be within -90 .. 90; the direction lies "
            "below the horizon"},
        BadCsv{"BelowTheHorizonOnTheOtherSide", kHeader + "-90,0,40,180,1,1,1\n",
               "s.csv:2: column theta_i_deg: is \"-90\", must be within -90 .. 90; the direction "
               "lies below the horizon"},
        BadCsv{"BelowTheHorizonInRadians", "theta_i_rad,theta_o_rad,phi_rad,f_r\n0.5,1.6,0,1\n",
               "s.csv:2: column theta_o_rad: is \"1.6\", must be within -pi/2 .. pi/2; the "
               "direction lies below the horizon"},
        BadCsv{"BelowTheHorizonByHalfAngles",
               "theta_h_deg,theta_d_deg,phi_d_deg,f_r\n10,10,0,1\n60,60,0,1\n",
               "s.csv:3: column theta_h_deg: is \"60\", with this theta_d and phi_d a direction "
               "lies below the horizon"},
        BadCsv{"NegativeHalfAngle", "theta_h_deg,theta_d_deg,phi_d_deg,f_r\n-1,10,0,1\n",
               "s.csv:2: column theta_h_deg: is \"-1\", must be >= 0"},
        BadCsv{"NoDifferenceAngle", "theta_h_deg,phi_d_deg,f_r\n1,10,1\n",
               "s.csv:1: column theta_d_deg is missing"},
        BadCsv{"BothUnits", "theta_i_deg,theta_i_rad,theta_o_deg,phi_deg,f_r\n1,1,1,1,1\n",
               "s.csv:1: columns theta_i_deg and theta_i_rad: one has to do"},
        BadCsv{"OneAndThreeChannels", "theta_i_deg,theta_o_deg,phi_deg,f_r,f_r_red\n1,1,1,1,1\n",
               "s.csv:1: columns f_r and f_r_red: one has to do"},
        BadCsv{"ZeroSigma", kWithSigma + "0,30,0,40,180,1,1,1,0,0\n",
               "s.csv:2: column sigma_red: is \"0\", must be a number > 0, or inf"},
        BadCsv{"SigmaNaN", kWithSigma + "0,30,0,40,180,1,1,1,nan,0\n",
               "s.csv:2: column sigma_red: is \"nan\", must be a number > 0, or inf"},
        BadCsv{"BrokenPose", kWithSigma + "1.5,30,0,40,180,1,1,1,1,0\n",
               "s.csv:2: column pose: is \"1.5\", must be a whole number"},
        BadCsv{"BrokenTime", kWithSigma + "1,30,0,40,180,1,1,1,1,noon\n",
               "s.csv:2: column time_s: is \"noon\", must be a finite number"}),
    [](const auto& test) { return test.param.label; });

TEST(SamplesCsv, NamesAFileThatIsMissing) {
  const TempDir dir;
  EXPECT_EQ(MessageOf<ConfigError>([&] { ReadSamplesCsv(dir / "s.csv"); }),
            (dir / "s.csv").string() + ": cannot read: No such file or directory");
}

TEST(SamplesCsvDeathTest, AbortsOnANumberThatIsNeitherFiniteNorMarkedUnusable) {
  std::vector<MeasuredSample> samples(1);
  samples[0].pose = 12;
  samples[0].sample.f_r[0] = std::nan("");
  samples[0].sample.sigma = Rgb::Ones();
  const TempDir dir;
  EXPECT_DEATH(WriteSamplesCsv(dir / "s.csv", samples), "pose 12");
}

}  // namespace
}  // namespace gonio
