// SPDX-License-Identifier: Apache-2.0
#include "planner/information_gain.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>

#include "core/check.h"
#include "core/units.h"
#include "fitting/generalised_log.h"
#include "fitting/slice.h"

namespace gonio {
namespace {

// Candidates whose images are scored because their middles would teach most.
constexpr std::ptrdiff_t kImageLeaders = 64;

// The share of phi_d at which both directions stay within max_polar, and the mean cos theta_i
// there.
void AverageOverPhi(const HalfDiff& at, double max_polar, double* share, double* cosine) {
  constexpr int kSteps = 60;
  const double limit = std::cos(max_polar);
  int inside = 0;
  double sum = 0;
  for (int p = 0; p < kSteps; ++p) {
    double cos_i = 0;
    double cos_o = 0;
    Cosines({at.theta_h, at.theta_d, (p + 0.5) * kPi / kSteps}, &cos_i, &cos_o);
    if (cos_i < limit || cos_o < limit) continue;
    ++inside;
    sum += cos_i;
  }
  *share = static_cast<double>(inside) / kSteps;
  *cosine = inside == 0 ? 0 : sum / inside;
}

// A symmetric matrix over spline coefficients seen at one theta_d, where the slice has
// `quantities` values: B M B' with B the spline's weights.
Eigen::MatrixXd Project(const Eigen::MatrixXd& full, int quantities, int knots,
                        const SplineBasis& basis) {
  const Eigen::Map<const Eigen::Vector4d> weight(basis.weight.data());
  Eigen::MatrixXd at_slice(quantities, quantities);
  for (int a = 0; a < quantities; ++a) {
    for (int b = 0; b <= a; ++b) {
      const auto block = full.block<4, 4>(a * knots + basis.first, b * knots + basis.first);
      at_slice(a, b) = at_slice(b, a) = weight.dot(block * weight);
    }
  }
  return at_slice;
}

// The transpose of Project: adds B' m B to `full`, m being one channel's block of a slice.
void Unproject(const Eigen::MatrixXd& at_slice, int offset, int knots, const SplineBasis& basis,
               Eigen::MatrixXd* full) {
  const Eigen::Map<const Eigen::Vector4d> weight(basis.weight.data());
  const Eigen::Matrix4d outer = weight * weight.transpose();
  for (int a = 0; a < at_slice.rows(); ++a) {
    for (int b = 0; b < at_slice.cols(); ++b) {
      full->block<4, 4>(offset + a * knots + basis.first, offset + b * knots + basis.first) +=
          at_slice(a, b) * outer;
    }
  }
}

double SquaredDistance(const HalfDiff& a, const HalfDiff& b) {
  const double dh = std::sqrt(a.theta_h / (kPi / 2)) - std::sqrt(b.theta_h / (kPi / 2));
  const double dd = (a.theta_d - b.theta_d) / (kPi / 2);
  return dh * dh + dd * dd;
}

// Sensitivity of the objective's quantity to f_r.
double ObjectiveSlope(Objective objective, double f_r, double cosine, double floor) {
  return objective == Objective::kMale ? cosine / (1 + f_r * cosine)
                                       : GeneralisedLogSlope(f_r, floor);
}

// The symmetric 3 x 3 matrix G' M G, G holding one channel's gradient per diagonal block.
Eigen::Matrix3d PerChannel(const Eigen::Ref<const Eigen::VectorXd>& gradient,
                           const Eigen::MatrixXd& matrix) {
  const Eigen::Index size = gradient.size() / kChannels;
  Eigen::Matrix3d result;
  for (int b = 0; b < kChannels; ++b) {
    const Eigen::VectorXd column =
        matrix.middleCols(b * size, size) * gradient.segment(b * size, size);
    for (int a = 0; a <= b; ++a) {
      result(a, b) = result(b, a) =
          gradient.segment(a * size, size).dot(column.segment(a * size, size));
    }
  }
  return result;
}

}  // namespace

// A fit's derivatives at every candidate.
struct InformationGain::Linearisation {
  int per_channel = 0;                                 // slice quantities of one channel
  Eigen::MatrixXd gradient;                            // of f_r; channels stacked, a column each
  Eigen::Matrix<double, kChannels, Eigen::Dynamic> f;  // f_r
  std::vector<SplineBasis> basis;                      // per column of the raster
  std::vector<Eigen::MatrixXd> covariance;             // parameter covariance, projected
};

InformationGain::InformationGain(std::vector<Candidate> candidates, const GainOptions& options)
    : candidates_(std::move(candidates)),
      options_(options),
      targets_(candidates_.size()),
      column_of_(candidates_.size()),
      parts_(candidates_, options_.parts) {
  std::map<int, std::vector<int>> by_column;
  double total = 0;
  for (std::size_t i = 0; i < candidates_.size(); ++i) {
    const Candidate& candidate = candidates_[i];
    by_column[candidate.column].push_back(static_cast<int>(i));
    Target& target = targets_[i];
    target.log_cos = LogCos(candidate.angles.theta_h);
    double share = 0;
    AverageOverPhi(candidate.angles, options_.max_polar, &share, &target.cosine);
    target.weight = share * candidate.cell_area;
    total += target.weight;
  }
  for (Target& target : targets_) target.weight /= total > 0 ? total : 1;
  for (auto& [column, members] : by_column) {
    const double theta_d = candidates_[members.front()].angles.theta_d;
    for (const int i : members) column_of_[i] = static_cast<int>(columns_.size());
    columns_.push_back({theta_d, std::move(members)});
  }
}

InformationGain::Linearisation InformationGain::Linearise(const DsbrdfFit& fit) const {
  const DsbrdfShape& shape = fit.model().shape();
  Linearisation at;
  at.per_channel = 2 * shape.lobes;
  const int quantities = kChannels * at.per_channel;
  const auto count = static_cast<Eigen::Index>(candidates_.size());
  at.gradient.resize(quantities, count);
  at.f.resize(kChannels, count);
  for (const Column& column : columns_) {
    const Slice slice(shape, fit.model().parameters(), column.theta_d);
    at.basis.push_back(slice.basis());
    at.covariance.push_back(Project(fit.covariance(), quantities, shape.knots, slice.basis()));
    for (const int i : column.members) {
      for (int c = 0; c < kChannels; ++c) {
        at.f(c, i) =
            slice.EvalWithGradient(c, targets_[i].log_cos, &at.gradient(c * at.per_channel, i));
      }
    }
  }
  return at;
}

Eigen::MatrixXd InformationGain::ObjectiveMatrix(const DsbrdfFit& fit, const Linearisation& at,
                                                 double* variance, double* predicted_error) const {
  const DsbrdfShape& shape = fit.model().shape();
  const double floor = fit.summary().floor;
  const int size = at.per_channel;
  Eigen::MatrixXd objective = Eigen::MatrixXd::Zero(shape.size(), shape.size());
  *variance = *predicted_error = 0;
  for (std::size_t k = 0; k < columns_.size(); ++k) {
    for (int c = 0; c < kChannels; ++c) {
      const Eigen::MatrixXd covariance = at.covariance[k].block(c * size, c * size, size, size);
      Eigen::MatrixXd sum = Eigen::MatrixXd::Zero(size, size);
      for (const int i : columns_[k].members) {
        const Target& target = targets_[i];
        if (target.weight <= 0) continue;
        const double slope = ObjectiveSlope(options_.objective, at.f(c, i), target.cosine, floor);
        const auto gradient = at.gradient.col(i).segment(c * size, size);
        const double known = slope * slope * gradient.dot(covariance * gradient);
        const double off_model =
            slope * fit.summary().model_error / GeneralisedLogSlope(at.f(c, i), floor);
        const double weight = target.weight / kChannels;
        *variance += weight * known;
        // Mean absolute value of a Gaussian: sqrt(2 / pi) sigma.
        *predicted_error += weight * std::sqrt(2 / kPi * (known + off_model * off_model));
        sum.noalias() += weight * slope * slope * gradient * gradient.transpose();
      }
      Unproject(sum, shape.Index(c, 0, 0), shape.knots, at.basis[k], &objective);
    }
  }
  return objective;
}

double InformationGain::Crowding(int candidate, const std::vector<int>& measured) const {
  const double scale = -0.5 / (options_.repeat_length * options_.repeat_length);
  double crowding = 1;
  for (const int m : measured) {
    const double exponent =
        scale * SquaredDistance(candidates_[candidate].angles, candidates_[m].angles);
    if (exponent > -20) crowding += std::exp(exponent);
  }
  return crowding;
}

GainScores InformationGain::Evaluate(const DsbrdfFit& fit, const std::vector<int>& measured) const {
  const DsbrdfShape& shape = fit.model().shape();
  const Linearisation at = Linearise(fit);
  GainScores scores{.gain = Eigen::VectorXd::Zero(at.f.cols())};
  double variance = 0;
  const Eigen::MatrixXd objective = ObjectiveMatrix(fit, at, &variance, &scores.predicted_error);
  if (!(variance > 0)) return scores;  // no candidate counts: nothing to gain
  const Eigen::MatrixXd taught = fit.covariance() * objective * fit.covariance();
  const double model_variance = fit.summary().model_error * fit.summary().model_error;
  for (std::size_t k = 0; k < columns_.size(); ++k) {
    const Eigen::MatrixXd taught_here =
        Project(taught, kChannels * at.per_channel, shape.knots, at.basis[k]);
    for (const int i : columns_[k].members) {
      Eigen::Vector3d slope;
      for (int c = 0; c < kChannels; ++c) {
        slope[c] = GeneralisedLogSlope(at.f(c, i), fit.summary().floor);
      }
      const Eigen::Matrix3d scale = slope * slope.transpose();
      Eigen::Matrix3d expected =
          PerChannel(at.gradient.col(i), at.covariance[k]).cwiseProduct(scale);
      const Eigen::Array3d noise = options_.relative_noise * at.f.col(i).array() * slope.array();
      expected.diagonal().array() += noise.square() + model_variance * Crowding(i, measured) + 1e-8;
      const Eigen::Matrix3d drop = PerChannel(at.gradient.col(i), taught_here).cwiseProduct(scale);
      scores.gain[i] = expected.llt().solve(drop).trace() / variance;
    }
  }
  if (parts_.any()) ScoreImages(fit, at, taught, measured, variance, &scores);
  return scores;
}

void InformationGain::ScoreImages(const DsbrdfFit& fit, const Linearisation& at,
                                  const Eigen::MatrixXd& taught, const std::vector<int>& measured,
                                  double variance, GainScores* scores) const {
  std::vector<int> images(candidates_.size());
  std::iota(images.begin(), images.end(), 0);
  const auto leaders = std::min(kImageLeaders, std::ssize(images));
  std::partial_sort(images.begin(), images.begin() + leaders, images.end(), [&](int a, int b) {
    return scores->gain[a] != scores->gain[b] ? scores->gain[a] > scores->gain[b] : a < b;
  });
  images.resize(leaders);
  images.insert(images.end(), parts_.scouts().begin(), parts_.scouts().end());
  for (const int i : images) {
    scores->gain[i] = ImageGain(fit, at, taught, parts_.Of(i), measured) / variance;
  }
}

double InformationGain::ImageGain(const DsbrdfFit& fit, const Linearisation& at,
                                  const Eigen::MatrixXd& taught, const std::vector<int>& parts,
                                  const std::vector<int>& measured) const {
  const DsbrdfShape& shape = fit.model().shape();
  const auto rows = kChannels * std::ssize(parts);
  Eigen::MatrixXd jacobian = Eigen::MatrixXd::Zero(shape.size(), rows);  // transposed
  Eigen::VectorXd shared(rows);
  Eigen::MatrixXd noise = Eigen::MatrixXd::Zero(rows, rows);
  for (Eigen::Index p = 0; p < std::ssize(parts); ++p) {
    const int i = parts[p];
    const SplineBasis& basis = at.basis[column_of_[i]];
    const Eigen::Map<const Eigen::Vector4d> weight(basis.weight.data());
    const double model = fit.summary().model_error * fit.summary().model_error;
    for (int c = 0; c < kChannels; ++c) {
      const Eigen::Index row = kChannels * p + c;
      const double slope = GeneralisedLogSlope(at.f(c, i), fit.summary().floor);
      for (int q = 0; q < at.per_channel; ++q) {
        jacobian.col(row).segment<4>(shape.Index(c, 0, 0) + q * shape.knots + basis.first) =
            slope * at.gradient(c * at.per_channel + q, i) * weight;
      }
      shared[row] = options_.relative_noise * at.f(c, i) * slope;
      noise(row, row) = model * Crowding(i, measured) + 1e-8;
    }
  }
  for (Eigen::Index a = 0; a < rows; ++a) {
    for (Eigen::Index b = a % kChannels; b < rows; b += kChannels) {
      noise(a, b) += shared[a] * shared[b];
    }
  }
  const Eigen::MatrixXd expected = jacobian.transpose() * (fit.covariance() * jacobian) + noise;
  const Eigen::MatrixXd drop = jacobian.transpose() * (taught * jacobian);
  return expected.llt().solve(drop).trace();
}

}  // namespace gonio
