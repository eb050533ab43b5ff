// SPDX-License-Identifier: Apache-2.0
#include "fitting/parameter_file.h"

#include <fmt/format.h>

#include "core/check.h"

namespace gonio {

void WriteNumbers(std::ostream& out, std::string_view key, const Eigen::VectorXd& numbers) {
  constexpr int kPerLine = 8;
  out << key << ": [";
  for (Eigen::Index i = 0; i < numbers.size(); ++i) {
    if (i > 0) out << (i % kPerLine == 0 ? ",\n  " : ", ");
    out << fmt::format("{}", numbers[i]);  // the shortest text that reads back as the same double
  }
  out << "]\n";
}

Eigen::VectorXd LowerOf(const Eigen::MatrixXd& symmetric) {
  const Eigen::Index n = symmetric.rows();
  Eigen::VectorXd lower(n * (n + 1) / 2);
  Eigen::Index at = 0;
  for (Eigen::Index row = 0; row < n; ++row) {
    for (Eigen::Index column = 0; column <= row; ++column) lower[at++] = symmetric(row, column);
  }
  return lower;
}

Eigen::MatrixXd SymmetricFromLower(const std::vector<double>& lower, int n) {
  GONIO_CHECK(static_cast<int>(lower.size()) == n * (n + 1) / 2, "one number per pair");
  Eigen::MatrixXd symmetric(n, n);
  std::size_t at = 0;
  for (int row = 0; row < n; ++row) {
    for (int column = 0; column <= row; ++column) {
      symmetric(row, column) = symmetric(column, row) = lower[at++];
    }
  }
  return symmetric;
}

}  // namespace gonio
