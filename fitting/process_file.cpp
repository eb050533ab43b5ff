// SPDX-License-Identifier: Apache-2.0
#include "fitting/process_file.h"

#include <fmt/format.h>

#include <string_view>
#include <vector>

#include "fitting/dsbrdf.h"

namespace gonio {
namespace {

constexpr int kMostKnots = 200;
constexpr int kMostComponents = 1000;
// What a coefficient of a logarithm, and its spread, may be without running over.
constexpr Range kLogarithm{.min = -1000, .max = 1000};
constexpr Range kSpread{.min = 0, .max = 1000};

void WriteRounded(std::ostream& out, std::string_view key,
                  const Eigen::Ref<const Eigen::MatrixXd>& numbers) {
  constexpr int kPerLine = 12;
  out << "  " << key << ": [";
  int i = 0;
  for (const double number : numbers.reshaped()) {
    if (i > 0) out << (i % kPerLine == 0 ? ",\n    " : ", ");
    out << fmt::format("{:.4g}", number);
    ++i;
  }
  out << "]\n";
}

Eigen::MatrixXd ReadMatrix(const ConfigNode& node, const char* key, int rows, int columns,
                           Range range) {
  const std::vector<double> numbers =
      node.Numbers(key, static_cast<std::size_t>(rows) * static_cast<std::size_t>(columns), range);
  return Eigen::Map<const Eigen::MatrixXd>(numbers.data(), rows, columns);
}

Eigen::MatrixXd ReadComponents(const ConfigNode& node, const char* key, int rows, int columns) {
  Eigen::MatrixXd components = ReadMatrix(node, key, rows, columns, kLogarithm);
  for (int i = 0; i < columns; ++i) {
    if ((components.col(i).array() == 0).all()) {
      node.Fail(key, fmt::format("component {} has no spread: all its numbers are 0", i + 1));
    }
  }
  return components;
}

}  // namespace

void WriteProcess(std::ostream& out, const ProcessPrior& process) {
  out << fmt::format(
      "process:\n  theta_h_knots: {}\n  theta_d_knots: {}\n  floor_per_sr: {}\n"
      "  luminance_components: {}\n  chroma_components: {}\n",
      process.basis.theta_h_knots(), process.basis.theta_d_knots(), process.floor,
      process.luminance.cols(), process.chroma.cols());
  WriteRounded(out, "mean", process.mean);
  WriteRounded(out, "stationary_luminance", process.stationary_luminance);
  WriteRounded(out, "stationary_chroma", process.stationary_chroma);
  WriteRounded(out, "luminance", process.luminance);
  WriteRounded(out, "chroma", process.chroma);
  out << fmt::format("  error_margin: {:.5g}\n", process.error_margin);
  if (process.calibration.empty()) return;
  Eigen::Matrix2Xd calibration(2, static_cast<Eigen::Index>(process.calibration.size()));
  for (Eigen::Index i = 0; i < calibration.cols(); ++i) {
    const Calibration& at = process.calibration[static_cast<std::size_t>(i)];
    calibration.col(i) << at.probability, at.widening;
  }
  WriteRounded(out, "interval_probabilities", calibration.row(0));
  WriteRounded(out, "interval_widenings", calibration.row(1));
}

std::shared_ptr<const ProcessPrior> ReadProcess(const ConfigNode& node) {
  auto process = std::make_shared<ProcessPrior>();
  const int theta_h_knots = node.Integer("theta_h_knots", kMinKnots, kMostKnots);
  const int theta_d_knots = node.Integer("theta_d_knots", kMinKnots, kMostKnots);
  process->basis = ProcessBasis(theta_h_knots, theta_d_knots);
  process->floor = node.Number("floor_per_sr", Range::Positive());
  const int size = process->basis.size();
  const int luminance = node.Integer("luminance_components", 1, kMostComponents);
  const int chroma = node.Integer("chroma_components", 1, kMostComponents);
  process->mean = ReadMatrix(node, "mean", size, 1, kLogarithm);
  process->stationary_luminance = ReadMatrix(node, "stationary_luminance", size, 1, kSpread);
  process->stationary_chroma = ReadMatrix(node, "stationary_chroma", size, 1, kSpread);
  process->luminance = ReadComponents(node, "luminance", size, luminance);
  process->chroma = ReadComponents(node, "chroma", size, chroma);
  process->error_margin = node.Number("error_margin", Range::Positive());
  if (!node.Has("interval_probabilities")) return process;
  const std::vector<double> probabilities =
      node.Numbers("interval_probabilities", 0, Range::Between(0, 1));
  const std::vector<double> widenings =
      node.Numbers("interval_widenings", probabilities.size(), Range::Positive());
  for (std::size_t i = 0; i < probabilities.size(); ++i) {
    if (i > 0 && probabilities[i] <= probabilities[i - 1]) {
      node.Fail("interval_probabilities", "must ascend");
    }
    process->calibration.push_back({probabilities[i], widenings[i]});
  }
  return process;
}

}  // namespace gonio
