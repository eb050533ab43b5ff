// SPDX-License-Identifier: Apache-2.0
// Prior files: what is written is read back, and what is broken is refused in one line.
#include <gtest/gtest.h>

#include <cmath>

#include "core/error.h"
#include "core/file.h"
#include "fitting/prior.h"
#include "sim/random.h"
#include "tests/core/temp_dir.h"

namespace gonio {
namespace {

// 24 parameters, with numbers that no short decimal text can hold.
Prior SmallPrior() {
  Prior prior = GenericPrior({.lobes = 1, .knots = 4});
  prior.name = "learned";
  prior.materials = {"alum-bronze", "pink felt", "paint: blue"};
  Random random(1, 0);
  for (double& m : prior.mean) m = random.Normal() / 3;
  prior.covariance.diagonal().array() += random.Uniform();
  return prior;
}

std::string Replaced(std::string text, const std::string& from, const std::string& to) {
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return text.replace(at, from.size(), to);
}

// The file of SmallPrior() with one thing changed.
class BadPriorFile : public testing::Test {
 protected:
  BadPriorFile() {
    WritePrior(dir_ / "good.yaml", SmallPrior());
    text_ = ReadTextFile(dir_ / "good.yaml");
  }
  // What ReadPrior() says, without the folder.
  std::string Complaint(const std::string& from, const std::string& to) {
    const auto path = dir_.File("bad.yaml", Replaced(text_, from, to));
    const std::string message = MessageOf<ConfigError>([&] { ReadPrior(path); });
    const std::string folder = dir_.path().string() + "/";
    EXPECT_EQ(message.find('\n'), std::string::npos);
    EXPECT_EQ(message.rfind(folder, 0), 0u) << message;
    return message.substr(std::min(folder.size(), message.size()));
  }

  TempDir dir_;
  std::string text_;
};

TEST(PriorFile, ReadsBackBitForBit) {
  const TempDir dir;
  for (const Prior& prior : {SmallPrior(), GenericPrior(), GenericPrior({5, 4})}) {
    WritePrior(dir / "prior.yaml", prior);
    const Prior read = ReadPrior(dir / "prior.yaml");
    EXPECT_EQ(read.name, prior.name);
    EXPECT_EQ(read.shape, prior.shape);
    EXPECT_EQ(read.materials, prior.materials);
    EXPECT_TRUE((read.mean.array() == prior.mean.array()).all());
    EXPECT_TRUE((read.covariance.array() == prior.covariance.array()).all());
  }
}

TEST(PriorFile, KeepsNamesThatYamlWouldReadOtherwise) {
  const TempDir dir;
  Prior prior = SmallPrior();
  for (const std::string name : {"a: b", "# not a comment", "\"quoted\"", "back\\slash", "[x]"}) {
    prior.name = name;
    prior.materials = {name, "plain"};
    WritePrior(dir / "prior.yaml", prior);
    const Prior read = ReadPrior(dir / "prior.yaml");
    EXPECT_EQ(read.name, name);
    EXPECT_EQ(read.materials, prior.materials);
  }
}

TEST(PriorFile, LeavesNothingElseBehind) {
  const TempDir dir;
  WritePrior(dir / "prior.yaml", SmallPrior());
  EXPECT_EQ(dir.CountFiles(), 1u);
}

TEST(PriorFile, IsRefusedWhenMissing) {
  const TempDir dir;
  const auto path = dir / "no.yaml";
  EXPECT_EQ(MessageOf<ConfigError>([&] { ReadPrior(path); }),
            path.string() + ": cannot read: No such file or directory");
}

TEST_F(BadPriorFile, OfAnotherFormat) {
  EXPECT_EQ(Complaint("gonio-prior", "gonio-fit"),
            "bad.yaml:1: format: is \"gonio-fit\", must be one of gonio-prior");
}

TEST_F(BadPriorFile, OfAnotherVersion) {
  EXPECT_EQ(Complaint("version: 1", "version: 2"),
            "bad.yaml:2: version: is 2, must be between 1 and 1");
}

TEST_F(BadPriorFile, OfABadShape) {
  EXPECT_EQ(Complaint("lobes: 1", "lobes: 6"), "bad.yaml:4: lobes: is 6, must be between 1 and 5");
  EXPECT_EQ(Complaint("knots: 4", "knots: 3"), "bad.yaml:5: knots: is 3, must be between 4 and 20");
  EXPECT_EQ(Complaint("knots: 4", "knots: 4.5"),
            "bad.yaml:5: knots: is 4.5, must be a whole number");
}

TEST_F(BadPriorFile, WithTooFewNumbersForItsShape) {
  EXPECT_EQ(Complaint("knots: 4", "knots: 5"), "bad.yaml:7: mean: must be a list of 30 numbers");
  EXPECT_EQ(Complaint("covariance_lower: [", "covariance_lower: [1, "),
            "bad.yaml:10: covariance_lower: must be a list of 300 numbers");
}

TEST_F(BadPriorFile, WithSomethingThatIsNoNumber) {
  for (const char* bad : {".nan", ".inf", "nan", "many", "[1]"}) {
    EXPECT_EQ(Complaint("mean: [", std::string("mean: [") + bad + ", "),
              "bad.yaml:7: mean: must be a list of 24 numbers");
  }
  const std::size_t begin = text_.find("mean: [") + 7;
  const std::string first = text_.substr(begin, text_.find(',', begin) - begin);
  for (const char* bad : {".nan", "-.inf", "nan", "many", "[1]", "~"}) {
    EXPECT_EQ(Complaint("mean: [" + first, std::string("mean: [") + bad),
              "bad.yaml:7: mean: holds something that is not a finite number");
  }
}

TEST_F(BadPriorFile, ThatIsNotPositiveDefinite) {
  const std::size_t begin = text_.find("covariance_lower: [") + 19;
  const std::string first = text_.substr(begin, text_.find(',', begin) - begin);
  for (const char* bad : {"-1", "0", "1e-9"}) {
    EXPECT_EQ(Complaint("covariance_lower: [" + first, std::string("covariance_lower: [") + bad),
              "bad.yaml:10: covariance_lower: is not positive definite");
  }
}

TEST_F(BadPriorFile, WithAnUnknownKey) {
  EXPECT_EQ(Complaint("knots: 4", "knots: 4\nlobe: 3"), "bad.yaml:6: lobe: is not a known key");
}

TEST_F(BadPriorFile, WithoutAKey) {
  EXPECT_EQ(Complaint("name: \"learned\"\n", ""), "bad.yaml:1: name: is missing");
  EXPECT_EQ(Complaint("mean: [", "means: ["), "bad.yaml:1: mean: is missing");
}

TEST_F(BadPriorFile, WhoseMaterialsAreNoList) {
  EXPECT_EQ(Complaint("materials: [", "materials: many # ["),
            "bad.yaml:6: materials: must be a list");
}

TEST_F(BadPriorFile, ThatWasCutShort) {
  const auto path = dir_.File("bad.yaml", text_.substr(0, text_.size() / 2));
  const std::string message = MessageOf<ConfigError>([&] { ReadPrior(path); });
  EXPECT_NE(message.find("bad.yaml:"), std::string::npos);
  EXPECT_NE(message.find("not valid YAML"), std::string::npos);
  EXPECT_EQ(message.find('\n'), std::string::npos);
}

}  // namespace
}  // namespace gonio
