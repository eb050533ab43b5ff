// SPDX-License-Identifier: Apache-2.0
#include "brdf/rt300s_csv.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>

#include "core/error.h"
#include "core/file.h"
#include "core/units.h"
#include "tests/core/temp_dir.h"

namespace gonio {
namespace {

const std::string kHeader =
    "sheet,col,clock,method,azimuth_deg,incidence_deg,receive_deg,RT,RT_per_nm,n_spec,spec380\n";

std::string Row(const std::string& clock, double azimuth, double incidence, double receive,
                double reading) {
  return "Sheet1,1," + clock + ",BRDF_LD," + std::to_string(azimuth) + "," +
         std::to_string(incidence) + "," + std::to_string(receive) + "," + std::to_string(reading) +
         ",1.7e-12,1,5.6e-06\n";
}

Rt300sSession Parse(const std::string& rows) { return ParseRt300s(kHeader + rows, "s.csv"); }

BrdfSample One(double azimuth, double incidence, double receive, double reading) {
  return Parse(Row("2011-02-13T11:07:15", azimuth, incidence, receive, reading)).samples[0].sample;
}

HalfDiff Angles(double azimuth, double incidence, double receive) {
  return ToHalfDiff(One(azimuth, incidence, receive, 1).directions);
}

// Example failure is the mirror taken for the way back to the light: the peak would be at 70 deg.
TEST(Rt300sCsv, HasTheMirrorWhereTheInstrumentHasIt) {
  EXPECT_NEAR(Angles(-90, 70, 70).theta_h, 0, 1e-7);
  EXPECT_NEAR(Angles(90, 70, -70).theta_h, 0, 1e-7);
  EXPECT_NEAR(Angles(90, 70, 70).theta_d, 0, 1e-7);
  EXPECT_NEAR(Angles(-90, 70, -70).theta_d, 0, 1e-7);
}

// Across the plane of incidence both sides are alike for an isotropic sample.
TEST(Rt300sCsv, IsSymmetricAcrossThePlaneOfIncidence) {
  EXPECT_NEAR(Angles(0, 30, 40).theta_h, Angles(0, 30, -40).theta_h, 1e-12);
  EXPECT_NEAR(Angles(-60, 30, 40).theta_d, Angles(60, 30, -40).theta_d, 1e-12);
}

TEST(Rt300sCsv, TakesTheReceiversCosineOutOfTheReadingAndKeepsNegativeOnes) {
  const BrdfSample sample = One(-90, 10, -60, -0.002);
  EXPECT_TRUE(sample.f_r.isApprox(Rgb::Constant(-0.004), 1e-9)) << sample.f_r;
  EXPECT_TRUE(sample.sigma.isApprox(Rgb::Constant(2 * (0.02 * 0.002 + kRt300sFloor)), 1e-9));
}

TEST(Rt300sCsv, TakesTimesFromTheClock) {
  const Rt300sSession session = Parse(Row("2011-02-28T23:59:58", -90, 10, 20, 1) +
                                      Row("2011-03-01T00:00:03", -90, 10, 25, 1));
  EXPECT_EQ(session.started, "2011-02-28T23:59:58");
  ASSERT_EQ(session.samples.size(), 2u);
  EXPECT_EQ(session.samples[0].time_s, 0);
  EXPECT_EQ(session.samples[1].time_s, 5);
  EXPECT_EQ(session.samples[1].pose, 1);
}

TEST(Rt300sCsv, IsKnownByItsHeader) {
  EXPECT_TRUE(LooksLikeRt300s(kHeader));
  EXPECT_FALSE(LooksLikeRt300s("theta_i_deg,phi_i_deg,theta_o_deg,phi_o_deg,f_r\n"));
  EXPECT_FALSE(LooksLikeRt300s(""));
}

struct BadRt300s {
  const char* label;
  std::string text;
  const char* complaint;
};

void PrintTo(const BadRt300s& bad, std::ostream* out) { *out << bad.label; }

class BadRt300sCsv : public testing::TestWithParam<BadRt300s> {};

TEST_P(BadRt300sCsv, IsRefusedWithItsLineAndColumn) {
  EXPECT_EQ(MessageOf<ConfigError>([] { ParseRt300s(GetParam().text, "s.csv"); }),
            GetParam().complaint);
}

const std::string kFew = "clock,azimuth_deg,incidence_deg,receive_deg,RT\n";

INSTANTIATE_TEST_SUITE_P(
    Rt300sCsv, BadRt300sCsv,
    testing::Values(
        BadRt300s{"Empty", "", "s.csv: holds no header row"},
        BadRt300s{"OnlyAHeader", kHeader, "s.csv: holds no readings"},
        BadRt300s{"NoReading", "clock,azimuth_deg,incidence_deg,receive_deg\n",
                  "s.csv:1: column RT is missing"},
        BadRt300s{"Grazing", kFew + "2011-02-13T11:07:15,0,10,90,1\n",
                  "s.csv:2: column receive_deg: is \"90\", must be within -90 .. 90; the direction "
                  "lies below the horizon"},
        BadRt300s{"Backwards", kFew + "2011-02-13T11:07:15,0,-95,10,1\n",
                  "s.csv:2: column incidence_deg: is \"-95\", must be within -90 .. 90; the "
                  "direction lies below the horizon"},
        BadRt300s{"Words", kFew + "2011-02-13T11:07:15,0,10,10,dark\n",
                  "s.csv:2: column RT: is \"dark\", must be a finite number"},
        BadRt300s{"TooLarge", kFew + "2011-02-13T11:07:15,0,10,89.9,1e308\n",
                  "s.csv:2: column RT: is \"1e308\", is too large"},
        BadRt300s{"NoSuchDay", kFew + "2011-02-30T11:07:15,0,10,10,1\n",
                  "s.csv:2: column clock: is \"2011-02-30T11:07:15\", must be like "
                  "2011-02-13T11:07:15"},
        BadRt300s{"CutOff", kFew + "2011-02-13T11:07:15,0,10,10,1\n2011-02-1",
                  "s.csv:3: has 1 cells, the header has 5"}),
    [](const auto& test) { return test.param.label; });

// Real sessions, as their source publishes them.
TEST(Rt300sFiles, KeepEveryReadingAndItsSign) {
  const char* dir = std::getenv("GONIO_DATA_DIR");
  struct File {
    const char* name;
    std::size_t readings;
    int negative;
  };
  int seen = 0;
  for (const auto& [name, readings, negative] :
       {File{"blank_20250829", 644, 243}, File{"MagicBlack_v1o0_20250829", 644, 41},
        File{"NiTE_on_invar_v1o0A_20250915", 2508, 126}}) {
    const auto path =
        std::filesystem::path(dir ? dir : "") / "rt300s" / (std::string(name) + ".csv");
    if (dir == nullptr || !std::filesystem::exists(path)) continue;
    ++seen;
    const std::string text = ReadTextFile(path);
    EXPECT_TRUE(LooksLikeRt300s(text));
    const Rt300sSession session = ParseRt300s(text, path.string());
    EXPECT_EQ(session.samples.size(), readings) << name;
    EXPECT_EQ(std::count_if(session.samples.begin(), session.samples.end(),
                            [](const MeasuredSample& m) { return m.sample.f_r[0] < 0; }),
              negative)
        << name;
  }
  if (seen == 0) GTEST_SKIP() << "GONIO_DATA_DIR has no rt300s folder";
}

}  // namespace
}  // namespace gonio
