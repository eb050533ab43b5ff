// SPDX-License-Identifier: Apache-2.0
#include "brdf/cornell_brdf.h"

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

// Four wavelengths: one of blue, two of green, one of red.
const std::string kHead =
    "# Some University\r\n# Grey card\r\n\r\n# num wls\r\n4\r\n\r\n# wls\r\n450 520\r\n540 650\r\n"
    "\r\n# theta i, phi i, theta s, phi_s, spectral sample values\r\n\r\n";

CornellBrdf Parse(const std::string& rows) { return ParseCornell(kHead + rows, "m.brdf"); }

TEST(CornellBrdf, AveragesTheWavelengthsOfEachChannel) {
  const CornellBrdf brdf = Parse("0.5 0 0.25 3.14159265 0.1 0.2 0.4 0.5\r\n");
  ASSERT_EQ(brdf.samples.size(), 1u);
  EXPECT_TRUE(brdf.samples[0].sample.f_r.isApprox(Rgb(0.5, 0.3, 0.1)));
  EXPECT_NEAR(brdf.samples[0].sample.sigma[0], 0.02 * 0.5 + kCornellFloor / std::cos(0.5), 1e-12);
  EXPECT_THAT(brdf.wavelengths_nm, testing::ElementsAre(450, 520, 540, 650));
  EXPECT_EQ(brdf.title, "Some University; Grey card");
}

// Example failure is phi counted from the mirror's side.
TEST(CornellBrdf, HasTheMirrorAtOppositeAzimuths) {
  const CornellBrdf brdf =
      Parse("0.5 0 0.5 3.141592653589793 1 1 1 1\n0.5 0 0.5 0 1 1 1 1\n0.5 0 -0.5 0 1 1 1 1\n");
  EXPECT_NEAR(ToHalfDiff(brdf.samples[0].sample.directions).theta_h, 0, 1e-7);
  EXPECT_NEAR(ToHalfDiff(brdf.samples[1].sample.directions).theta_d, 0, 1e-7);
  EXPECT_NEAR(ToHalfDiff(brdf.samples[2].sample.directions).theta_h, 0, 1e-7);
}

TEST(CornellBrdf, KeepsNegativeValuesAndCountsZeros) {
  const CornellBrdf brdf = Parse("0.5 0 0.5 1 -0.1 0 0 0\n0.5 0 0.5 1 0 -0.1 0.1 1\n");
  EXPECT_EQ(brdf.samples[0].sample.f_r[2], -0.1);
  EXPECT_EQ(brdf.zeros, 3);  // green and red of the first, blue of the second
}

TEST(CornellBrdf, TakesOtherBands) {
  WavelengthBands bands = kColourBands;
  bands[0] = {530, 550};
  const CornellBrdf brdf = ParseCornell(kHead + "0.5 0 0.5 1 1 2 4 8\n", "m.brdf", bands);
  EXPECT_TRUE((brdf.samples[0].sample.f_r == Rgb(4, 3, 1)).all());
}

struct BadBrdf {
  const char* label;
  std::string text;
  const char* complaint;
};

void PrintTo(const BadBrdf& bad, std::ostream* out) { *out << bad.label; }

class BadCornellBrdf : public testing::TestWithParam<BadBrdf> {};

TEST_P(BadCornellBrdf, IsRefusedWithItsLineAndNumber) {
  EXPECT_EQ(MessageOf<ConfigError>([] { ParseCornell(GetParam().text, "m.brdf"); }),
            GetParam().complaint);
}

INSTANTIATE_TEST_SUITE_P(
    CornellBrdf, BadCornellBrdf,
    testing::Values(
        BadBrdf{"Empty", "# nothing\n", "m.brdf: holds no number of wavelengths"},
        BadBrdf{"OnlyAHead", kHead, "m.brdf: holds no samples"},
        BadBrdf{"NoCount", "450 520\n",
                "m.brdf:1: number 1 (number of wavelengths): is \"450\", must be a whole number of "
                "1 to 4096, alone on its line"},
        BadBrdf{"EndlessCount", "1e9\n",
                "m.brdf:1: number 1 (number of wavelengths): is \"1e9\", must be a whole number of "
                "1 to 4096, alone on its line"},
        BadBrdf{"FewWavelengths", "2\n450\n", "m.brdf:2: has 1 wavelengths, not 2"},
        BadBrdf{"ManyWavelengths", "1\n450 460\n",
                "m.brdf:2: number 2 (wavelength): is \"460\", there should be 1 of them"},
        BadBrdf{"Dark", "1\n0\n", "m.brdf:2: number 1 (wavelength): is \"0\", must be > 0"},
        BadBrdf{"NoRed", "2\n450 550\n0 0 0 0 1 1\n",
                "m.brdf: has no wavelength from 600 to 700 nm, only 450 to 550"},
        BadBrdf{"ShortRow", kHead + "0.5 0 0.5 1 1 1 1\n",
                "m.brdf:13: has 7 numbers, not 4 angles and 4 values"},
        BadBrdf{"Grazing", kHead + "0.5 0 1.5708 1 1 1 1 1\n",
                "m.brdf:13: number 3 (theta_s): is \"1.5708\", must be within -pi/2 .. pi/2; the "
                "direction lies below the horizon"},
        BadBrdf{"Degrees", kHead + "50 0 1 1 1 1 1 1\n",
                "m.brdf:13: number 1 (theta_i): is \"50\", must be within -pi/2 .. pi/2; the "
                "direction lies below the horizon"},
        BadBrdf{"Words", kHead + "0.5 0 0.5 1 1 1 1 dark\n",
                "m.brdf:13: number 8 (650 nm): is \"dark\", must be a finite number"},
        BadBrdf{"NaN", kHead + "0.5 nan 0.5 1 1 1 1 1\n",
                "m.brdf:13: number 2 (phi_i): is \"nan\", must be a finite number"},
        BadBrdf{"TooLarge", kHead + "0.5 0 0.5 1 1 1.7e308 1.7e308 1\n",
                "m.brdf:13: has values that are too large"}),
    [](const auto& test) { return test.param.label; });

// Real materials, as their source publishes them.
TEST(CornellFiles, AreReadWhole) {
  const char* dir = std::getenv("GONIO_DATA_DIR");
  int seen = 0;
  for (const char* name : {"krylon_blue.brdf", "mystique.brdf"}) {
    const auto path = std::filesystem::path(dir ? dir : "") / "cornell" / name;
    if (dir == nullptr || !std::filesystem::exists(path)) continue;
    ++seen;
    const CornellBrdf brdf = ParseCornell(ReadTextFile(path), path.string());
    EXPECT_EQ(brdf.wavelengths_nm.size(), 31u) << name;
    ASSERT_EQ(brdf.samples.size(), 1439u) << name;
    // The highest value stands where light and detector are nearest to the mirror.
    const auto highest = std::max_element(
        brdf.samples.begin(), brdf.samples.end(),
        [](const auto& a, const auto& b) { return a.sample.f_r[1] < b.sample.f_r[1]; });
    EXPECT_LT(ToHalfDiff(highest->sample.directions).theta_h, RadFromDeg(1.5)) << name;
  }
  if (seen == 0) GTEST_SKIP() << "GONIO_DATA_DIR has no cornell folder";
}

}  // namespace
}  // namespace gonio
