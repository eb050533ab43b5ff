// SPDX-License-Identifier: Apache-2.0
// Fit files: what is written is read back, and what is broken is refused in one line.
#include <gtest/gtest.h>

#include <stdexcept>

#include "core/error.h"
#include "core/file.h"
#include "fitting/fit.h"
#include "tests/core/temp_dir.h"
#include "tests/fitting/synthetic.h"

namespace gonio {
namespace {

constexpr DsbrdfShape kSmall{.lobes = 1, .knots = 4};  // 24 parameters

const DsbrdfFit& SmallFit() {
  static const DsbrdfFit fit =
      FitDsbrdf(Readings(SyntheticMaterial(1, kSmall), 20, 0.02, 1), GenericPrior(kSmall));
  return fit;
}

std::string Replaced(std::string text, const std::string& from, const std::string& to) {
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return text.replace(at, from.size(), to);
}

TEST(FitFile, ReadsBackBitForBit) {
  const TempDir dir;
  WriteFit(dir / "fit.yaml", SmallFit());
  EXPECT_EQ(dir.CountFiles(), 1u);
  const DsbrdfFit read = ReadFit(dir / "fit.yaml");
  EXPECT_EQ(read.name(), "fit.yaml");
  EXPECT_EQ(read.model().shape(), kSmall);
  EXPECT_TRUE((read.model().parameters().array() == SmallFit().model().parameters().array()).all());
  EXPECT_TRUE((read.covariance().array() == SmallFit().covariance().array()).all());
  const FitSummary& a = read.summary();
  const FitSummary& b = SmallFit().summary();
  EXPECT_EQ(a.converged, b.converged);
  EXPECT_EQ(a.reason, b.reason);
  EXPECT_EQ(a.samples, b.samples);
  EXPECT_EQ(a.residuals, b.residuals);
  EXPECT_EQ(a.iterations, b.iterations);
  EXPECT_EQ(a.starts, b.starts);
  EXPECT_EQ(a.cost, b.cost);
  EXPECT_EQ(a.model_error, b.model_error);
  EXPECT_EQ(a.floor, b.floor);
}

// Files of the first release had neither `method` nor this version.
TEST(FitFile, ReadsVersionOne) {
  const TempDir dir;
  WriteFit(dir / "fit.yaml", SmallFit());
  const std::string text =
      Replaced(ReadTextFile(dir / "fit.yaml"), "version: 2\nmethod: continuous\n", "version: 1\n");
  EXPECT_EQ(ReadFit(dir.File("old.yaml", text)).summary().cost, SmallFit().summary().cost);
}

TEST(FitFile, PredictsTheSameOnceRead) {
  const TempDir dir;
  WriteFit(dir / "fit.yaml", SmallFit());
  const DsbrdfFit read = ReadFit(dir / "fit.yaml");
  for (const HalfDiff& angles : {HalfDiff{0, 0.2, 0}, HalfDiff{0.3, 0.9, 1.5}}) {
    EXPECT_TRUE((read.Predict(angles).f_r == SmallFit().Predict(angles).f_r).all());
    EXPECT_TRUE((read.Predict(angles).sigma == SmallFit().Predict(angles).sigma).all());
  }
}

TEST(FitFile, IsRefusedInOneLineNamingFileLineAndKey) {
  const TempDir dir;
  WriteFit(dir / "good.yaml", SmallFit());
  const std::string text = ReadTextFile(dir / "good.yaml");
  const auto complaint = [&](const std::string& from, const std::string& to) {
    const auto path = dir.File("bad.yaml", Replaced(text, from, to));
    const std::string message = MessageOf<ConfigError>([&] { ReadFit(path); });
    const std::string folder = dir.path().string() + "/";
    EXPECT_EQ(message.rfind(folder, 0), 0u) << message;
    return message.substr(std::min(folder.size(), message.size()));
  };
  EXPECT_EQ(complaint("gonio-fit", "gonio-prior"),
            "bad.yaml:3: format: is \"gonio-prior\", must be one of gonio-fit");
  EXPECT_EQ(complaint("version: 2", "version: 0"),
            "bad.yaml:4: version: is 0, must be between 1 and 2");
  EXPECT_EQ(complaint("lobes: 1", "lobes: 2"),
            "bad.yaml:18: parameters: must be a list of 48 numbers");
  EXPECT_EQ(complaint("  floor_per_sr: 0.03", "  floor_per_sr: 0"),
            "bad.yaml:17: summary.floor_per_sr: is 0, must be > 0");
  EXPECT_EQ(complaint("  starts", "  begins"), "bad.yaml:9: summary.starts: is missing");
  EXPECT_EQ(complaint("  converged: true", "  converged: maybe"),
            "bad.yaml:9: summary.converged: is \"maybe\", must be true or false");
  EXPECT_EQ(complaint("covariance_lower: [", "covariance_lower: [-"),
            "bad.yaml:21: covariance_lower: is not positive definite");
  EXPECT_EQ(complaint("parameters: [", "more: 1\nparameters: ["),
            "bad.yaml:18: more: is not a known key");
}

TEST(FitFile, IsNotWrittenIntoAMissingFolder) {
  const TempDir dir;
  EXPECT_THROW(WriteFit(dir / "no" / "fit.yaml", SmallFit()), std::runtime_error);
  EXPECT_EQ(dir.CountFiles(), 0u);
}

}  // namespace
}  // namespace gonio
