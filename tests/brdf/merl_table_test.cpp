// SPDX-License-Identifier: Apache-2.0
#include "brdf/merl_table.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <limits>

#include "core/error.h"
#include "core/file.h"
#include "core/units.h"
#include "tests/core/temp_dir.h"

namespace gonio {
namespace {

namespace fs = std::filesystem;
using testing::HasSubstr;

// Different in every cell and channel.
std::optional<Rgb> Pattern(const HalfDiff& x) {
  return Rgb(0.1 + x.theta_h, 0.2 + x.theta_d * x.theta_h, 0.3 + std::sin(2 * x.phi_d) * 0.1);
}

const MerlTable& PatternTable() {
  static const MerlTable table = MerlTable::FromFunction("pattern", Pattern);
  return table;
}

double Stored(const fs::path& path, int channel, int h, int d, int p) {
  std::ifstream in(path, std::ios::binary);
  in.seekg(12 + 8 * (((channel * 90LL + h) * 90 + d) * 180 + p));
  double stored = 0;
  in.read(reinterpret_cast<char*>(&stored), sizeof stored);
  return stored;
}

template <typename Number>
void Patch(const fs::path& path, std::streamoff offset, Number number) {
  std::fstream file(path, std::ios::binary | std::ios::in | std::ios::out);
  file.seekp(offset);
  file.write(reinterpret_cast<const char*>(&number), sizeof number);
}

std::streamoff OffsetOf(int channel, int h, int d, int p) {
  return 12 + 8 * (((channel * 90LL + h) * 90 + d) * 180 + p);
}

void ExpectNear(const Rgb& a, const Rgb& b, double tolerance) {
  EXPECT_LT((a - b).abs().maxCoeff(), tolerance) << a.transpose() << " / " << b.transpose();
}

TEST(MerlTable, HasItsCellsWhereTheFormatSays) {
  const HalfDiff first = MerlTable::CellCentre(0, 0, 0);
  EXPECT_DOUBLE_EQ(DegFromRad(first.theta_h), 90 * std::pow(0.5 / 90, 2));
  EXPECT_DOUBLE_EQ(DegFromRad(first.theta_d), 0.5);
  EXPECT_DOUBLE_EQ(DegFromRad(first.phi_d), 0.5);
  const HalfDiff last = MerlTable::CellCentre(89, 89, 179);
  EXPECT_DOUBLE_EQ(DegFromRad(last.theta_h), 90 * std::pow(89.5 / 90, 2));
  EXPECT_DOUBLE_EQ(DegFromRad(last.theta_d), 89.5);
  EXPECT_DOUBLE_EQ(DegFromRad(last.phi_d), 179.5);
}

TEST(MerlTable, HasThetaHWidthsThatAddUpToARightAngle) {
  double sum = 0;
  for (int h = 0; h < MerlTable::kThetaH; ++h) sum += MerlTable::ThetaHWidth(h);
  EXPECT_NEAR(sum, kPi / 2, 1e-14);
}

TEST(MerlTable, IsInvalidBelowTheHorizonAndThereOnly) {
  int valid = 0;
  for (int h = 0; h < MerlTable::kThetaH; ++h) {
    for (int d = 0; d < MerlTable::kThetaD; ++d) {
      for (int p = 0; p < MerlTable::kPhiD; ++p) {
        const bool above = ToDirections(MerlTable::CellCentre(h, d, p)).above_horizon();
        ASSERT_EQ(PatternTable().Cell(h, d, p).has_value(), above) << h << " " << d << " " << p;
        valid += above;
      }
    }
  }
  EXPECT_NEAR(valid / double{MerlTable::kCells}, 0.75, 0.01);
}

TEST(MerlTable, WritesTheLayoutOfTheDatabase) {
  const TempDir dir;
  const fs::path path = dir / "pattern.binary";
  PatternTable().Write(path);
  EXPECT_EQ(fs::file_size(path), 34992012u);
  std::array<int, 3> dimensions{};
  std::ifstream(path, std::ios::binary).read(reinterpret_cast<char*>(dimensions.data()), 12);
  EXPECT_THAT(dimensions, testing::ElementsAre(90, 90, 180));
  const Rgb f_r = *Pattern(MerlTable::CellCentre(20, 10, 30));
  EXPECT_NEAR(Stored(path, 0, 20, 10, 30), f_r[0] * 1500, 1e-12 * 1500);
  EXPECT_NEAR(Stored(path, 1, 20, 10, 30), f_r[1] * 1500 / 1.15, 1e-12 * 1500);
  EXPECT_NEAR(Stored(path, 2, 20, 10, 30), f_r[2] * 1500 / 1.66, 1e-12 * 1500);
  EXPECT_LT(Stored(path, 0, 89, 89, 0), 0);
}

TEST(MerlTable, IsReadBackAsItWasWritten) {
  const TempDir dir;
  const fs::path path = dir / "my pattern.binary";
  PatternTable().Write(path);
  const MerlTable read = MerlTable::Open(path);
  EXPECT_EQ(read.name(), "my pattern");
  for (int h = 0; h < MerlTable::kThetaH; h += 7) {
    for (int d = 0; d < MerlTable::kThetaD; d += 7) {
      for (int p = 0; p < MerlTable::kPhiD; p += 7) {
        const auto a = PatternTable().Cell(h, d, p), b = read.Cell(h, d, p);
        ASSERT_EQ(a.has_value(), b.has_value());
        if (!a) continue;
        EXPECT_TRUE((*a == *b).all());
        ExpectNear(*b, *Pattern(MerlTable::CellCentre(h, d, p)), 1e-15);
      }
    }
  }
  read.Write(dir / "again.binary");
  EXPECT_TRUE(ReadTextFile(path) == ReadTextFile(dir / "again.binary"));
}

TEST(MerlTable, StaysReadableAfterItsFileIsReplaced) {
  const TempDir dir;
  const fs::path path = dir / "x.binary";
  PatternTable().Write(path);
  const MerlTable read = MerlTable::Open(path);
  MerlTable::FromFunction("y", [](const HalfDiff&) { return Rgb(9, 9, 9); }).Write(path);
  ExpectNear(*read.Cell(40, 10, 30), *PatternTable().Cell(40, 10, 30), 1e-15);
}

TEST(MerlTable, TakesACellAsInvalidIfAnyChannelIsNegativeOrNotFinite) {
  const TempDir dir;
  const fs::path path = dir / "x.binary";
  PatternTable().Write(path);
  const double bad[] = {-1, -1e-300, std::numeric_limits<double>::quiet_NaN(),
                        std::numeric_limits<double>::infinity()};
  for (int channel = 0; channel < kChannels; ++channel) {
    for (int k = 0; k < 4; ++k) Patch(path, OffsetOf(channel, 10 + k, 20, channel), bad[k]);
  }
  const MerlTable table = MerlTable::Open(path);
  for (int channel = 0; channel < kChannels; ++channel) {
    for (int k = 0; k < 4; ++k) {
      EXPECT_FALSE(table.Cell(10 + k, 20, channel)) << channel << " " << bad[k];
      EXPECT_FALSE(table.Eval(MerlTable::CellCentre(10 + k, 20, channel)));
    }
  }
  EXPECT_TRUE(table.Cell(14, 20, 0));
}

TEST(MerlTable, TakesZeroAsAValue) {
  const MerlTable black = MerlTable::FromFunction("black", [](auto&) { return Rgb(0, 0, 0); });
  ASSERT_TRUE(black.Cell(3, 4, 5));
  EXPECT_EQ(black.Cell(3, 4, 5)->sum(), 0);
}

TEST(MerlTable, MarksWhatAFunctionCannotTell) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const MerlTable table = MerlTable::FromFunction("x", [&](const HalfDiff& x) {
    if (x.theta_d < 0.2) return std::optional<Rgb>();
    if (x.theta_d < 0.4) return std::optional<Rgb>(Rgb(1, nan, 1));
    if (x.theta_d < 0.6) return std::optional<Rgb>(Rgb(1, 1, -0.1));
    return std::optional<Rgb>(Rgb(1, 1, 1));
  });
  EXPECT_FALSE(table.Cell(5, 5, 5));
  EXPECT_FALSE(table.Cell(5, 15, 5));
  EXPECT_FALSE(table.Cell(5, 30, 5));
  EXPECT_TRUE(table.Cell(5, 45, 5));
}

TEST(MerlTable, GivesTheCellItselfAtItsCentre) {
  for (int h = 0; h < MerlTable::kThetaH; h += 3) {
    for (int d = 0; d < MerlTable::kThetaD; d += 3) {
      for (int p = 0; p < MerlTable::kPhiD; ++p) {
        const auto cell = PatternTable().Cell(h, d, p);
        const auto f_r = PatternTable().Eval(MerlTable::CellCentre(h, d, p));
        ASSERT_EQ(cell.has_value(), f_r.has_value());
        ASSERT_TRUE(!cell || (*cell == *f_r).all()) << h << " " << d << " " << p;
      }
    }
  }
}

TEST(MerlTable, IsLinearBetweenCentresInTheWarpedAngles) {
  const auto linear = [](const HalfDiff& x) {
    return Rgb(std::sqrt(x.theta_h), x.theta_d, 1 + std::sqrt(x.theta_h) * x.theta_d);
  };
  const MerlTable table = MerlTable::FromFunction("linear", linear);
  for (const double theta_h : {0.001, 0.01, 0.1, 0.3}) {
    for (const double theta_d : {0.02, 0.1234, 0.5, 0.9}) {
      const HalfDiff angles{theta_h, theta_d, 1.234};
      ExpectNear(*table.Eval(angles), linear(angles), 1e-13);
    }
  }
}

TEST(MerlTable, IsConstantBeyondTheOutermostCentres) {
  const MerlTable& table = PatternTable();
  ExpectNear(*table.Eval({0, MerlTable::CellCentre(0, 30, 60).theta_d, kPi / 180 * 60.5}),
             *table.Cell(0, 30, 60), 1e-15);
  ExpectNear(*table.Eval({MerlTable::CellCentre(30, 0, 0).theta_h, 0, kPi / 180 * 60.5}),
             *table.Cell(30, 0, 60), 1e-15);
  ExpectNear(*table.Eval({1e-4, RadFromDeg(89.9), RadFromDeg(90.5)}), *table.Cell(3, 89, 90), 0.1);
}

TEST(MerlTable, WrapsPhiAtHalfATurn) {
  const MerlTable table = MerlTable::FromFunction(
      "step", [](const HalfDiff& x) { return Rgb::Constant(x.phi_d < kPi / 2 ? 1 : 3); });
  const double theta_h = MerlTable::CellCentre(20, 0, 0).theta_h;
  const double theta_d = MerlTable::CellCentre(0, 20, 0).theta_d;
  EXPECT_NEAR((*table.Eval({theta_h, theta_d, 0}))[0], 2, 1e-12);
  EXPECT_NEAR((*table.Eval({theta_h, theta_d, RadFromDeg(0.25)}))[0], 1.5, 1e-12);
  EXPECT_NEAR((*table.Eval({theta_h, theta_d, RadFromDeg(179.75)}))[0], 2.5, 1e-12);
  for (const double phi : {0.0, 0.3, 1.0, 3.0}) {
    const HalfDiff a{theta_h, theta_d, phi};
    for (const double turn : {kPi, -kPi, 2 * kPi}) {
      EXPECT_NEAR((*table.Eval(a))[0], (*table.Eval({theta_h, theta_d, phi + turn}))[0], 1e-11);
    }
  }
}

TEST(MerlTable, NeverBlendsInvalidCells) {
  const auto holes = [](const HalfDiff& x) -> std::optional<Rgb> {
    const int d = static_cast<int>(DegFromRad(x.theta_d)),
              p = static_cast<int>(DegFromRad(x.phi_d));
    if ((d / 3 + p / 3) % 2 == 0) return std::nullopt;
    return Rgb(2, 2, 2);
  };
  const MerlTable table = MerlTable::FromFunction("holes", holes);
  int known = 0, unknown = 0;
  for (double theta_d = 0.001; theta_d < 0.7; theta_d += 0.0123) {
    for (double phi_d = 0.001; phi_d < kPi; phi_d += 0.0077) {
      const HalfDiff angles{0.3, theta_d, phi_d};
      const auto f_r = table.Eval(angles);
      ASSERT_EQ(f_r.has_value(), holes(angles).has_value()) << theta_d << " " << phi_d;
      ASSERT_NEAR(f_r ? (*f_r)[1] : 2, 2, 1e-14);
      ++(f_r ? known : unknown);
    }
  }
  EXPECT_GT(known, 1000);
  EXPECT_GT(unknown, 1000);
}

TEST(MerlTable, KnowsNothingBelowTheHorizonOrAtNaN) {
  EXPECT_FALSE(PatternTable().Eval(HalfDiff{1.5, 1.5, 0.1}));
  EXPECT_FALSE(PatternTable().Eval(HalfDiff{std::nan(""), 0.1, 0.1}));
  EXPECT_FALSE(PatternTable().Eval(DirectionPair{FromSpherical(1.6, 0), FromSpherical(0.1, 0)}));
  EXPECT_TRUE(PatternTable().Eval(DirectionPair{FromSpherical(1.0, 0), FromSpherical(0.1, 0)}));
}

TEST(MerlTable, RefusesAMissingFileAndAFolder) {
  const TempDir dir;
  EXPECT_EQ(MessageOf<ConfigError>([&] { MerlTable::Open(dir / "x.binary"); }),
            (dir / "x.binary").string() + ": cannot read: No such file or directory");
  EXPECT_EQ(MessageOf<ConfigError>([&] { MerlTable::Open(dir.path()); }),
            dir.path().string() + ": cannot read: Is a directory");
}

TEST(MerlTable, RefusesAFileOfTheWrongSize) {
  const TempDir dir;
  const fs::path path = dir / "x.binary";
  PatternTable().Write(path);
  const auto open = [&] { MerlTable::Open(path); };
  fs::resize_file(path, 34992013);
  EXPECT_EQ(MessageOf<ConfigError>(open),
            path.string() + ": is too long: has 34992013 bytes, a MERL table has 34992012");
  fs::resize_file(path, 20000000);
  EXPECT_EQ(MessageOf<ConfigError>(open),
            path.string() + ": is truncated: has 20000000 bytes, a MERL table has 34992012");
  fs::resize_file(path, 5);
  EXPECT_THAT(MessageOf<ConfigError>(open), HasSubstr(": is truncated: has 5 bytes"));
  fs::resize_file(path, 0);
  EXPECT_THAT(MessageOf<ConfigError>(open), HasSubstr(": is truncated: has 0 bytes"));
}

TEST(MerlTable, RefusesOtherDimensions) {
  const TempDir dir;
  const fs::path path = dir / "x.binary";
  PatternTable().Write(path);
  Patch(path, 8, 360);
  EXPECT_EQ(MessageOf<ConfigError>([&] { MerlTable::Open(path); }),
            path.string() + ": has dimensions 90 x 90 x 360, a MERL table has 90 x 90 x 180");
}

TEST(MerlTable, RefusesAFileWithoutAnyValidCell) {
  const TempDir dir;
  const fs::path path = dir / "x.binary";
  MerlTable::FromFunction("none", [](auto&) { return std::nullopt; }).Write(path);
  EXPECT_EQ(
      MessageOf<ConfigError>([&] { MerlTable::Open(path); }),
      path.string() + ": holds no valid cell: each has a channel that is negative or not finite");
}

TEST(MerlTable, ReportsAFolderItCannotWriteTo) {
  const TempDir dir;
  EXPECT_THAT(MessageOf<std::runtime_error>([&] { PatternTable().Write(dir / "no" / "x"); }),
              HasSubstr("cannot write: No such file or directory"));
}

TEST(MerlTableDeathTest, AbortsOnACellOutsideTheTable) {
  EXPECT_DEATH((void)PatternTable().Cell(0, 0, 180), "cell 0, 0, 180");
}

// The folder of the environment variable holds NAME.binary files in the layout of the database.
TEST(MerlTable, OpensTheDatabasesOwnFiles) {
  const char* folder = std::getenv("GONIO_DATA_DIR");
  if (folder == nullptr) GTEST_SKIP() << "GONIO_DATA_DIR is not set: no MERL data to read";
  const fs::path path = fs::path(folder) / "alum-bronze.binary";
  if (!fs::exists(path)) GTEST_SKIP() << path << " does not exist";
  const MerlTable table = MerlTable::Open(path);
  EXPECT_EQ(table.name(), "alum-bronze");
  int valid = 0;
  for (int h = 0; h < MerlTable::kThetaH; ++h) {
    for (int d = 0; d < MerlTable::kThetaD; ++d) {
      for (int p = 0; p < MerlTable::kPhiD; ++p) valid += table.Cell(h, d, p).has_value();
    }
  }
  EXPECT_NEAR(valid / double{MerlTable::kCells}, 0.75, 0.02);
}

}  // namespace
}  // namespace gonio
