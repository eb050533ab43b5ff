// SPDX-License-Identifier: Apache-2.0
// What fit and prior files share: long lists of numbers and packed symmetric matrices.

#pragma once

#include <Eigen/Core>
#include <ostream>
#include <string_view>
#include <vector>

namespace gonio {

// "key: [1, 2, ...]" on as many lines as it takes, each number so that it reads back bit for bit.
void WriteNumbers(std::ostream& out, std::string_view key, const Eigen::VectorXd& numbers);

// The lower triangle, row by row: n (n + 1) / 2 numbers.
Eigen::VectorXd LowerOf(const Eigen::MatrixXd& symmetric);
// Precondition: lower.size() == n (n + 1) / 2.
Eigen::MatrixXd SymmetricFromLower(const std::vector<double>& lower, int n);

}  // namespace gonio
