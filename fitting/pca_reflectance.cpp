// SPDX-License-Identifier: Apache-2.0
#include "fitting/pca_reflectance.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "core/check.h"
#include "core/error.h"
#include "core/units.h"
#include "fitting/grid_reflectance.h"

namespace gonio {
namespace {

constexpr double kEpsilon = 1e-3;  // the mapping's, 1/sr
const double kLeastCosine = std::cos(RadFromDeg(87));
constexpr double kPublishedColumns = 240;  // 80 materials of 3 channels
constexpr double kNegligible = 1e-5;       // of the largest singular value
constexpr int kBlock = 4096;               // nodes transformed at once

double CosMap(const HalfDiff& angles) {
  double cos_i = 0;
  double cos_o = 0;
  Cosines(angles, &cos_i, &cos_o);
  return std::max(cos_i, kLeastCosine) * std::max(cos_o, kLeastCosine);
}

// The coefficients of one channel; empty without readings.
Eigen::VectorXd Coefficients(std::span<const BrdfSample> samples, int channel,
                             const PcaBasis& basis, const PcaOptions& options) {
  std::vector<HalfDiff> at;
  std::vector<double> centred;
  for (const BrdfSample& sample : samples) {
    if (!std::isfinite(sample.sigma[channel]) || !std::isfinite(sample.f_r[channel])) continue;
    at.push_back(ToHalfDiff(sample.directions));
    centred.push_back(basis.Map(sample.f_r[channel], at.back()) - basis.Mean(at.back()));
  }
  const int count = static_cast<int>(at.size());
  const int components =
      std::min(options.components > 0 ? options.components : count, basis.rank());
  Eigen::MatrixXd rows(count, components);
  for (int i = 0; i < count; ++i) rows.row(i) = basis.Row(at[i]).head(components);
  const double ridge = options.ridge * basis.columns() / kPublishedColumns;
  const Eigen::MatrixXd normal =
      rows.transpose() * rows + ridge * Eigen::MatrixXd::Identity(components, components);
  const Eigen::Map<const Eigen::VectorXd> right(centred.data(), count);
  return normal.llt().solve(rows.transpose() * right);
}

}  // namespace

PcaBasis::PcaBasis(std::span<const TrainingMaterial> materials, const AngleGrid& grid)
    : grid_(grid) {
  if (materials.size() < 2) throw ConfigError("principal components need at least two materials");
  for (const TrainingMaterial& material : materials) materials_.push_back(material.name);
  Decompose(MappedColumns(materials));
}

// columns x nodes of m - mean; sets the reference and the mean on the way.
Eigen::MatrixXf PcaBasis::MappedColumns(std::span<const TrainingMaterial> materials) {
  Eigen::MatrixXf mapped(columns(), grid_.size());
  for (std::size_t i = 0; i < materials.size(); ++i) {
    mapped.middleRows(static_cast<Eigen::Index>(kChannels * i), kChannels) =
        SampleOnGrid(*materials[i].brdf, grid_);
  }
  log_reference_.resize(grid_.size());
  mean_.resize(grid_.size());
  std::vector<float> sorted(columns());
  for (int node = 0; node < grid_.size(); ++node) {
    auto column = mapped.col(node).array();
    column = column * static_cast<float>(CosMap(grid_.Node(node)));
    std::copy(column.begin(), column.end(), sorted.begin());
    const auto middle = sorted.begin() + columns() / 2;
    std::nth_element(sorted.begin(), middle, sorted.end());
    log_reference_[node] = std::log(*middle + static_cast<float>(kEpsilon));
    column = (column + static_cast<float>(kEpsilon)).log() - log_reference_[node];
    mean_[node] = column.mean();
    column -= mean_[node];
  }
  return mapped;
}

// With X = U S V', Q = U S = X V, so the eigenvectors of X'X do for any number of nodes.
void PcaBasis::Decompose(Eigen::MatrixXf columns) {
  const Eigen::Index count = columns.rows();
  Eigen::MatrixXd gram = Eigen::MatrixXd::Zero(count, count);
  Eigen::MatrixXf block(count, kBlock);
  int filled = 0;
  const auto flush = [&] {
    gram += (block.leftCols(filled) * block.leftCols(filled).transpose()).cast<double>();
    filled = 0;
  };
  for (int node = 0; node < grid_.size(); ++node) {
    if (grid_.Physical(node)) block.col(filled++) = columns.col(node);
    if (filled == kBlock) flush();
  }
  flush();
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(gram);
  singular_values_ = solver.eigenvalues().reverse().cwiseMax(0).cwiseSqrt();
  Eigen::Index rank = 0;
  while (rank < count && singular_values_[rank] > kNegligible * singular_values_[0]) ++rank;
  if (rank == 0) throw ConfigError("principal components: the materials are all alike");
  singular_values_.conservativeResize(rank);
  const Eigen::MatrixXf v = solver.eigenvectors().rowwise().reverse().leftCols(rank).cast<float>();
  for (Eigen::Index start = 0; start < columns.cols(); start += kBlock) {  // in place
    const Eigen::Index size = std::min<Eigen::Index>(kBlock, columns.cols() - start);
    columns.block(0, start, rank, size) = (v.transpose() * columns.middleCols(start, size)).eval();
  }
  columns.conservativeResize(rank, Eigen::NoChange);
  scaled_ = std::move(columns);
}

double PcaBasis::Interpolate(const Eigen::VectorXf& at_nodes, const HalfDiff& angles) const {
  double sum = 0;
  for (const AngleGrid::Corner& corner : grid_.Locate(angles)) {
    sum += corner.weight * at_nodes[corner.index];
  }
  return sum;
}

Eigen::VectorXd PcaBasis::Row(const HalfDiff& angles) const {
  Eigen::VectorXd row = Eigen::VectorXd::Zero(rank());
  for (const AngleGrid::Corner& corner : grid_.Locate(angles)) {
    row += corner.weight * scaled_.col(corner.index).cast<double>();
  }
  return row;
}

double PcaBasis::Mean(const HalfDiff& angles) const { return Interpolate(mean_, angles); }

double PcaBasis::Map(double f_r, const HalfDiff& angles) const {
  return std::log(std::max(f_r, 0.0) * CosMap(angles) + kEpsilon) -
         Interpolate(log_reference_, angles);
}

double PcaBasis::Unmap(double mapped, int node) const {
  const double f_r_cos = std::exp(mapped + log_reference_[node]) - kEpsilon;
  return std::max(f_r_cos, 0.0) / CosMap(grid_.Node(node));
}

std::unique_ptr<Brdf> Reconstruct(std::span<const BrdfSample> samples, const PcaBasis& basis,
                                  const PcaOptions& options) {
  GONIO_CHECK(options.ridge > 0, "without a ridge few samples decide nothing");
  Eigen::Matrix3Xf f_r(kChannels, basis.grid().size());
  for (int c = 0; c < kChannels; ++c) {
    const Eigen::VectorXf coefficients = Coefficients(samples, c, basis, options).cast<float>();
    const Eigen::VectorXf mapped =
        basis.mean() + basis.scaled().topRows(coefficients.size()).transpose() * coefficients;
    for (int node = 0; node < basis.grid().size(); ++node) {
      f_r(c, node) = static_cast<float>(basis.Unmap(mapped[node], node));
    }
  }
  return std::make_unique<GridReflectance>("principal components", basis.grid(), f_r);
}

}  // namespace gonio
