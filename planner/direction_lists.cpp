// SPDX-License-Identifier: Apache-2.0
#include "planner/direction_lists.h"

#include <algorithm>
#include <cmath>

namespace gonio {
namespace {

struct PublishedDirection {
  double phi_d_deg, theta_h_deg, theta_d_deg;
};
constexpr PublishedDirection kNielsen[] = {{36.2, 1.4, 4.0},
                                           {86.5, 76.7, 13.1},
                                           {85.5, 7.6, 78.9},
                                           {144.8, 2.5, 73.8},
                                           {80.4, 12.9, 51.6}};

// What no component explains, per training column.
constexpr double kUnexplained = 0.02 / 96;
// The weight of phi_d in the distance of poses: it matters least.
constexpr double kPhiWeight = 0.2;
constexpr double kUsedUp = 1e-9;  // of S's sum of squares: rounding is all that is left

// Distance on (sqrt(theta_h / 90 deg), theta_d / 90 deg, phi_d), squared; phi_d has period pi.
double Distance(const HalfDiff& a, const HalfDiff& b) {
  const double u = std::sqrt(a.theta_h / (kPi / 2)) - std::sqrt(b.theta_h / (kPi / 2));
  const double v = (a.theta_d - b.theta_d) / (kPi / 2);
  const double w = kPhiWeight * std::sin(a.phi_d - b.phi_d);
  return u * u + v * v + w * w;
}

bool NearTheHorizon(const Candidate& candidate) {
  const double limit = std::cos(kListMaxPolar);
  return candidate.directions.cos_theta_i() < limit || candidate.directions.cos_theta_o() < limit;
}

// The candidates a list may take from; all of them if none is far enough from the horizon.
std::vector<int> Eligible(const std::vector<Candidate>& candidates) {
  std::vector<int> eligible;
  std::vector<int> all;
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    all.push_back(static_cast<int>(i));
    if (!NearTheHorizon(candidates[i])) eligible.push_back(static_cast<int>(i));
  }
  return eligible.empty() ? all : eligible;
}

// Rows of Q, one column for each of `among`.
Eigen::MatrixXd Rows(const std::vector<Candidate>& candidates, const std::vector<int>& among,
                     const PcaBasis& basis) {
  Eigen::MatrixXd rows(basis.rank(), static_cast<Eigen::Index>(among.size()));
  for (std::size_t i = 0; i < among.size(); ++i) {
    rows.col(static_cast<Eigen::Index>(i)) = basis.Row(candidates[among[i]].angles);
  }
  return rows;
}

// Index of the largest score that was not taken yet; the first of equals.
Eigen::Index Best(const Eigen::VectorXd& score, const std::vector<char>& taken) {
  Eigen::Index best = -1;
  for (Eigen::Index i = 0; i < score.size(); ++i) {
    if (!taken[i] && (best < 0 || score[i] > score[best])) best = i;
  }
  return best;
}

}  // namespace

std::vector<int> NielsenOrder(const std::vector<Candidate>& candidates) {
  const std::vector<int> eligible = Eligible(candidates);
  std::vector<int> order;
  for (const PublishedDirection& published : kNielsen) {
    const HalfDiff wanted{RadFromDeg(published.theta_h_deg), RadFromDeg(published.theta_d_deg),
                          RadFromDeg(published.phi_d_deg)};
    const auto nearest = std::min_element(eligible.begin(), eligible.end(), [&](int a, int b) {
      return Distance(candidates[a].angles, wanted) < Distance(candidates[b].angles, wanted);
    });
    if (nearest == eligible.end()) break;
    if (std::find(order.begin(), order.end(), *nearest) == order.end()) order.push_back(*nearest);
  }
  return order;
}

// The Gram matrix of the columns is Q Q' + d I, and the squared norm that QR leaves of a column is
// what Cholesky leaves on its diagonal; so this never builds the tall identity.
std::vector<int> PivotedOrder(const std::vector<Candidate>& candidates, const PcaBasis& basis,
                              int count) {
  const std::vector<int> eligible = Eligible(candidates);
  const Eigen::MatrixXd q = Rows(candidates, eligible, basis);
  const double unexplained = kUnexplained * basis.columns();
  count = std::min(count, static_cast<int>(eligible.size()));
  Eigen::MatrixXd factor(q.cols(), count);
  Eigen::VectorXd left = q.colwise().squaredNorm();
  std::vector<char> taken(eligible.size(), false);
  std::vector<int> order;
  for (int k = 0; k < count; ++k) {
    const Eigen::Index best = Best(left, taken);
    taken[best] = true;
    order.push_back(eligible[best]);
    Eigen::VectorXd column = q.transpose() * q.col(best);
    column -= factor.leftCols(k) * factor.row(best).head(k).transpose();
    factor.col(k) = column / std::sqrt(std::max(left[best], 0.0) + unexplained);
    left -= factor.col(k).cwiseAbs2();
  }
  return order;
}

std::vector<int> FrostOrder(const std::vector<Candidate>& candidates, const PcaBasis& basis,
                            int count) {
  const std::vector<int> eligible = Eligible(candidates);
  count = std::min(count, static_cast<int>(eligible.size()));
  const int components = std::min(count, basis.rank());
  const Eigen::VectorXd singular = basis.singular_values().head(components);
  Eigen::MatrixXd atoms =
      singular.cwiseInverse().asDiagonal() * Rows(candidates, eligible, basis).topRows(components);
  atoms.colwise().normalize();
  // S = diag(singular) V': V turns the columns about and changes no sum of squares over them.
  const Eigen::MatrixXd all = singular.asDiagonal();
  Eigen::MatrixXd residual, correlation, spanned(components, components);
  std::vector<char> taken(eligible.size(), false);
  std::vector<int> order;
  for (int k = components; static_cast<int>(order.size()) < count; ++k) {
    if (k == components || residual.squaredNorm() < kUsedUp * all.squaredNorm()) {
      k = 0;
      residual = all;
      correlation = atoms.transpose() * residual;
    }
    const Eigen::Index best = Best(correlation.rowwise().squaredNorm(), taken);
    taken[best] = true;
    order.push_back(eligible[best]);
    Eigen::VectorXd direction = atoms.col(best);
    for (int pass = 0; pass < 2; ++pass) {  // the second for what rounding left
      direction -= spanned.leftCols(k) * (spanned.leftCols(k).transpose() * direction);
    }
    direction.normalize();
    spanned.col(k) = direction;
    const Eigen::RowVectorXd part = direction.transpose() * residual;
    residual -= direction * part;
    correlation -= (atoms.transpose() * direction) * part;
  }
  return order;
}

}  // namespace gonio
