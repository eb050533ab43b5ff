// SPDX-License-Identifier: Apache-2.0
// Reflectance as a mean plus principal components of other materials: what planners that start from
// a database reconstruct with.

#pragma once

#include <Eigen/Core>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "brdf/brdf.h"
#include "fitting/angle_grid.h"
#include "fitting/training.h"

namespace gonio {

// The principal components of training materials, each colour channel a column of its own, in the
// log-relative mapping of Nielsen, Jensen & Ramamoorthi ("On Optimal, Minimal BRDF Sampling for
// Reflectance Acquisition", ICCV 2015):
//
//   m = ln((f_r cosMap + eps) / (ref + eps)),  cosMap = cos theta_i cos theta_o,  eps = 1e-3
//
// ref: median over the training columns of f_r cosMap. x = mean + Q c, Q = U S of the singular
// value decomposition of the centred columns: a training column has c of variance 1 / columns.
//
// Theirs has a row for each cell of a MERL table, ours one for each node of a grid as dense in
// theta_h and thinner in theta_d and phi_d; in between, m is interpolated. Cosines count as at
// least cos 87 deg, so that f_r stays finite next to the horizon; nodes below it do not count in
// the decomposition.
//
// Immutable; safe to read from several threads. Keeps 4 bytes per node and training column (36 MB
// for 40 materials); learning that much takes about 3 s.
class PcaBasis {
 public:
  // Throws ConfigError if there are fewer than two materials or one has no value anywhere.
  explicit PcaBasis(std::span<const TrainingMaterial> materials,
                    const AngleGrid& grid = DefaultGrid());

  static AngleGrid DefaultGrid() { return {90, 46, 18}; }

  const std::vector<std::string>& materials() const { return materials_; }
  const AngleGrid& grid() const { return grid_; }
  // Number of components with a singular value above rounding; at most 3 x materials - 1.
  int rank() const { return static_cast<int>(scaled_.rows()); }
  // Number of training columns, 3 x materials.
  int columns() const { return kChannels * static_cast<int>(materials_.size()); }
  // Non-increasing, rank() of them.
  const Eigen::VectorXd& singular_values() const { return singular_values_; }

  // The row of Q at a direction: rank() numbers, interpolated.
  Eigen::VectorXd Row(const HalfDiff& angles) const;
  // The mean of m at a direction.
  double Mean(const HalfDiff& angles) const;
  // m of f_r [1/sr], negative readings counting as 0, and back.
  double Map(double f_r, const HalfDiff& angles) const;
  // f_r at a node for its m.
  double Unmap(double mapped, int node) const;

  // Q, transposed, and the mean of m: column i, and number i, is node i.
  const Eigen::MatrixXf& scaled() const { return scaled_; }
  const Eigen::VectorXf& mean() const { return mean_; }

 private:
  Eigen::MatrixXf MappedColumns(std::span<const TrainingMaterial> materials);
  void Decompose(Eigen::MatrixXf columns);
  double Interpolate(const Eigen::VectorXf& at_nodes, const HalfDiff& angles) const;

  std::vector<std::string> materials_;
  AngleGrid grid_;
  Eigen::VectorXf log_reference_;  // ln(ref + eps) at each node
  Eigen::VectorXf mean_;
  Eigen::MatrixXf scaled_;  // rank x nodes
  Eigen::VectorXd singular_values_;
};

struct PcaOptions {
  // > 0: Nielsen et al.'s eta for the 240 training columns they had in each fold. With other
  // numbers of columns it is scaled, so that the prior on m stays what it was: c varies as 1 /
  // columns.
  double ridge = 40;
  int components = 0;  // > 0: so many; 0: as many as there are samples, as published
};

// c = (Qs'Qs + r I)^-1 Qs'(m_s - mean_s) for each channel, s the rows of the samples, r = ridge x
// columns / 240. Sigma does not matter, as published, except that readings of infinite sigma are
// left out; a channel without readings is the mean.
//
// What is returned is a GridReflectance: a value wherever both directions are above the horizon.
// The basis is not needed any more.
std::unique_ptr<Brdf> Reconstruct(std::span<const BrdfSample> samples, const PcaBasis& basis,
                                  const PcaOptions& options = {});

}  // namespace gonio
