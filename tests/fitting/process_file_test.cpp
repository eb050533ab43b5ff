// SPDX-License-Identifier: Apache-2.0
// The process in a prior file: read back, and refused in one line where it is broken.
#include "fitting/process_file.h"

#include <gtest/gtest.h>

#include "core/error.h"
#include "core/file.h"
#include "fitting/prior.h"
#include "tests/core/temp_dir.h"

namespace gonio {
namespace {

constexpr int kSize = 64;  // of 4 x 4 knots

// Numbers that five digits hold.
Prior SmallPrior() {
  auto process = std::make_shared<ProcessPrior>();
  process->basis = ProcessBasis(4, 4);
  process->mean = Eigen::VectorXd::Constant(kSize, -1.25);
  process->luminance = Eigen::MatrixXd::Constant(kSize, 2, 0.75);
  process->luminance(3, 1) = -0.5;
  process->chroma = Eigen::MatrixXd::Constant(kSize, 1, 0.125);
  process->stationary_luminance = Eigen::VectorXd::Constant(kSize, 0.25);
  process->stationary_chroma = Eigen::VectorXd::Constant(kSize, 0.0625);
  process->calibration = {{0.5, 1.5}, {0.9, 2}};
  Prior prior = GenericPrior({.lobes = 1, .knots = 4});
  prior.process = process;
  return prior;
}

class ProcessFile : public testing::Test {
 protected:
  ProcessFile() {
    WritePrior(dir_ / "good.yaml", SmallPrior());
    text_ = ReadTextFile(dir_ / "good.yaml");
  }
  // What ReadPrior() says, behind folder, file and line, of the file with the last `from` replaced.
  std::string Complaint(const std::string& from, const std::string& to) {
    std::string text = text_;
    const std::size_t at = text.rfind(from);
    EXPECT_NE(at, std::string::npos) << from;
    if (at == std::string::npos) return "";
    const auto path = dir_.File("bad.yaml", text.replace(at, from.size(), to));
    const std::string message = MessageOf<ConfigError>([&] { ReadPrior(path); });
    const std::string file = path.string() + ":";
    EXPECT_EQ(message.rfind(file, 0), 0u) << message;
    EXPECT_EQ(message.find('\n'), std::string::npos);
    const std::size_t line = message.find(": ", file.size());
    return line == std::string::npos ? message : message.substr(line + 2);
  }

  TempDir dir_;
  std::string text_;
};

TEST_F(ProcessFile, IsReadBack) {
  const Prior read = ReadPrior(dir_ / "good.yaml");
  const Prior prior = SmallPrior();
  ASSERT_NE(read.process, nullptr);
  EXPECT_EQ(read.process->basis, prior.process->basis);
  EXPECT_EQ(read.process->mean, prior.process->mean);
  EXPECT_EQ(read.process->luminance, prior.process->luminance);
  EXPECT_EQ(read.process->chroma, prior.process->chroma);
  EXPECT_EQ(read.process->stationary_luminance, prior.process->stationary_luminance);
  EXPECT_EQ(read.process->stationary_chroma, prior.process->stationary_chroma);
  ASSERT_EQ(read.process->calibration.size(), 2u);
  EXPECT_EQ(read.process->calibration[1].widening, 2);
}

TEST_F(ProcessFile, WithOtherKnotsThanItsNumbers) {
  EXPECT_EQ(Complaint("theta_h_knots: 4", "theta_h_knots: 5"),
            "process.mean: must be a list of 80 numbers");
  EXPECT_EQ(Complaint("theta_d_knots: 4", "theta_d_knots: 3"),
            "process.theta_d_knots: is 3, must be between 4 and 200");
  EXPECT_EQ(Complaint("theta_h_knots: 4", "theta_h_knots: 201"),
            "process.theta_h_knots: is 201, must be between 4 and 200");
}

TEST_F(ProcessFile, WithOtherChannels) {
  EXPECT_EQ(Complaint("  chroma: [", "  uv: ["), "process.chroma: is missing");
  EXPECT_EQ(Complaint("  chroma: [", "  near_infrared: 1\n  chroma: ["),
            "process.near_infrared: is not a known key");
}

TEST_F(ProcessFile, WithComponentsOfAnotherSize) {
  EXPECT_EQ(Complaint("luminance_components: 2", "luminance_components: 3"),
            "process.luminance: must be a list of 192 numbers");
  EXPECT_EQ(Complaint("chroma: [0.125", "chroma: [0.125, 0.125"),
            "process.chroma: must be a list of 64 numbers");
  EXPECT_EQ(Complaint("chroma_components: 1", "chroma_components: 0"),
            "process.chroma_components: is 0, must be between 1 and 1000");
}

TEST_F(ProcessFile, WithNumbersThatAreNone) {
  for (const char* bad : {".nan", "-.inf", "many"}) {
    EXPECT_EQ(Complaint("mean: [-1.25", std::string("mean: [") + bad),
              "process.mean: holds something that is not a finite number");
    EXPECT_EQ(Complaint("chroma: [0.125", std::string("chroma: [") + bad),
              "process.chroma: holds something that is not a finite number");
  }
  // Finite, but no logarithm of a reflectance: the process would overflow.
  EXPECT_EQ(Complaint("mean: [-1.25", "mean: [1e300"),
            "process.mean: holds 1e+300, must be between -1000 and 1000");
}

TEST_F(ProcessFile, WithASpreadThatIsNone) {
  EXPECT_EQ(Complaint("stationary_chroma: [0.0625", "stationary_chroma: [-0.0625"),
            "process.stationary_chroma: holds -0.0625, must be between 0 and 1000");
  EXPECT_EQ(Complaint("floor_per_sr: 0.02", "floor_per_sr: 0"),
            "process.floor_per_sr: is 0, must be > 0");
  EXPECT_EQ(Complaint("interval_widenings: [1.5", "interval_widenings: [0"),
            "process.interval_widenings: holds 0, must be > 0");
  EXPECT_EQ(Complaint("interval_probabilities: [0.5", "interval_probabilities: [0.95"),
            "process.interval_probabilities: must ascend");
  Prior prior = SmallPrior();
  auto process = std::make_shared<ProcessPrior>(*prior.process);
  process->luminance.col(1).setZero();
  prior.process = process;
  WritePrior(dir_ / "good.yaml", prior);
  text_ = ReadTextFile(dir_ / "good.yaml");
  EXPECT_EQ(Complaint("version: 1", "version: 1"),
            "process.luminance: component 2 has no spread: all its numbers are 0");
}

}  // namespace
}  // namespace gonio
