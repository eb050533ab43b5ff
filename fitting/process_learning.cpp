// SPDX-License-Identifier: Apache-2.0
#include "fitting/process_learning.h"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <iterator>

#include "core/error.h"
#include "core/units.h"
#include "fitting/generalised_log.h"

namespace gonio {
namespace {

const double kMostPolar = std::cos(RadFromDeg(86));
const double kTrustedPolar = std::cos(RadFromDeg(80));
// Of the directions beyond kTrustedPolar, where tables are extrapolated.
constexpr double kUntrusted = 0.1;
// What each row counts beside its width, so that the highlight is not lost.
constexpr double kRowFloor = 0.2;
constexpr double kSmoothness = 1e-5;

// A luminance curve of a channel alone counts so much, as does one of a scaled material: they widen
// what a few dozen materials span.
constexpr double kChannelWeight = 0.3;
constexpr double kScaledWeight = 0.3;

constexpr double kGreyTint = 0.05;  // of log f_r: what chroma may do where all materials are grey

constexpr int kSpreadFolds = 8;
constexpr double kLeftoverNoise = 0.03;  // of the readings the leftover is what cannot explain
// Coefficients that count less in the metric belong to directions below the horizon.
constexpr double kSeen = 1e-8;

void AddOuter(const ProcessBasis::Terms& terms, double weight, Eigen::MatrixXd* matrix) {
  for (int i = 0; i < ProcessBasis::kTerms; ++i) {
    for (int j = 0; j < ProcessBasis::kTerms; ++j) {
      (*matrix)(terms.index[j], terms.index[i]) += weight * terms.weight[i] * terms.weight[j];
    }
  }
}

// Squares of second differences of neighbouring coefficients along theta_h and theta_d.
Eigen::MatrixXd Smoothness(const ProcessBasis& basis) {
  Eigen::MatrixXd matrix = 1e-3 * Eigen::MatrixXd::Identity(basis.size(), basis.size());
  const auto add = [&](int a, int b, int c) {
    const int index[3] = {a, b, c};
    const double weight[3] = {1, -2, 1};
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) matrix(index[i], index[j]) += weight[i] * weight[j];
    }
  };
  for (int h = 0; h < basis.theta_h_knots(); ++h) {
    for (int d = 0; d < basis.theta_d_knots(); ++d) {
      for (int k = 0; k < ProcessBasis::kHarmonics; ++k) {
        if (h >= 2) add(basis.Index(h - 2, d, k), basis.Index(h - 1, d, k), basis.Index(h, d, k));
        if (d >= 2) add(basis.Index(h, d - 2, k), basis.Index(h, d - 1, k), basis.Index(h, d, k));
      }
    }
  }
  return matrix;
}

// Principal components of weighted curves about `mean`, scaled by their standard deviations.
Eigen::MatrixXd Components(const Eigen::MatrixXd& curves, const Eigen::VectorXd& weights,
                           const Eigen::VectorXd& mean, const Eigen::MatrixXd& metric, int most) {
  const Eigen::VectorXd roots = (weights / weights.sum()).cwiseSqrt();
  const Eigen::MatrixXd scaled = (curves.colwise() - mean) * roots.asDiagonal();
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(scaled.transpose() *
                                                             (metric * scaled));
  const double least = 1e-8 * eigen.eigenvalues().tail(1)[0];
  const auto usable = (eigen.eigenvalues().array() > least).count();
  const Eigen::Index count = std::min<Eigen::Index>(most, usable);
  return scaled * eigen.eigenvectors().rightCols(count).rowwise().reverse();
}

using Series = Eigen::Matrix<double, Eigen::Dynamic, kChannels>;

// Luminance and chroma of the three channels' curves.
Series SeriesOf(const Eigen::MatrixXd& z) {
  const Series series = z * LuminanceAndChroma().transpose();
  return series;
}

}  // namespace

FieldSampler::FieldSampler(const ProcessBasis& basis, double floor, const ReadingRaster& raster)
    : basis_(basis), floor_(floor), smoothness_(kSmoothness * Smoothness(basis)) {
  double total = 0;
  for (int h = 0; h < raster.theta_h; ++h) {
    const double u = (h + 0.5) / raster.theta_h;
    for (int d = 0; d < raster.theta_d; ++d) {
      for (int p = 0; p < raster.phi_d; ++p) {
        const HalfDiff angles{u * u * kPi / 2, (d + 0.5) / raster.theta_d * kPi / 2,
                              (p + 0.5) / raster.phi_d * kPi};
        double cos_i = 0;
        double cos_o = 0;
        Cosines(angles, &cos_i, &cos_o);
        const double nearest = std::min(cos_i, cos_o);
        if (nearest < kMostPolar) continue;
        const double weight = (2 * u + kRowFloor) * (nearest < kTrustedPolar ? kUntrusted : 1);
        points_.push_back({angles, weight});
        total += weight;
      }
    }
  }
  metric_.setZero(basis.size(), basis.size());
  for (Point& point : points_) {
    point.weight /= total;
    AddOuter(basis_.At(point.angles), point.weight, &metric_);
  }
}

MaterialField FieldSampler::Sample(const TrainingMaterial& material) const {
  constexpr auto kScaleCount = static_cast<int>(std::size(MaterialField::kScales));
  Eigen::MatrixXd normal = metric_ + smoothness_;
  Eigen::MatrixXd pull = Eigen::MatrixXd::Zero(basis_.size(), kChannels * kScaleCount);
  Eigen::VectorXd z(kChannels * kScaleCount);
  std::size_t unknown = 0;
  for (const Point& point : points_) {
    const ProcessBasis::Terms terms = basis_.At(point.angles);
    const std::optional<Rgb> f_r = material.brdf->Eval(point.angles);
    if (!f_r || !f_r->isFinite().all()) {
      ++unknown;
      AddOuter(terms, -point.weight, &normal);
      continue;
    }
    for (int s = 0; s < kScaleCount; ++s) {
      for (int c = 0; c < kChannels; ++c) {
        z[s * kChannels + c] =
            GeneralisedLog(MaterialField::kScales[s] * std::max((*f_r)[c], 0.0), floor_);
      }
    }
    for (int i = 0; i < ProcessBasis::kTerms; ++i) {
      pull.row(terms.index[i]) += point.weight * terms.weight[i] * z.transpose();
    }
  }
  if (2 * unknown > points_.size()) {
    throw ConfigError(fmt::format(
        "{}: knows {:.0f} % of the directions; a prior needs half or more", material.name,
        100.0 * static_cast<double>(points_.size() - unknown) /
            static_cast<double>(points_.size())));
  }
  return {material.name, normal.llt().solve(pull)};
}

namespace {

ProcessPrior LearnComponents(std::span<const MaterialField* const> fields,
                             const ProcessBasis& basis, double floor, const Eigen::MatrixXd& metric,
                             const ComponentCounts& counts) {
  constexpr auto kScaleCount = static_cast<int>(std::size(MaterialField::kScales));
  const auto n = static_cast<Eigen::Index>(fields.size());
  const Eigen::Index per_field = kScaleCount + kChannels;
  Eigen::MatrixXd luminance(basis.size(), n * per_field);
  Eigen::VectorXd weights(n * per_field);
  Eigen::MatrixXd chroma(basis.size(), 2 * n);
  for (Eigen::Index m = 0; m < n; ++m) {
    const Eigen::MatrixXd& z = fields[m]->coefficients;
    for (Eigen::Index s = 0; s < kScaleCount; ++s) {
      luminance.col(m * per_field + s) =
          z.middleCols(s * kChannels, kChannels).rowwise().sum() / std::sqrt(3.0);
      weights[m * per_field + s] = s == 0 ? 1 : kScaledWeight;
    }
    for (Eigen::Index c = 0; c < kChannels; ++c) {
      luminance.col(m * per_field + kScaleCount + c) = std::sqrt(3.0) * z.col(c);
      weights[m * per_field + kScaleCount + c] = kChannelWeight;
    }
    chroma.middleCols(2 * m, 2) = SeriesOf(z.leftCols(kChannels)).rightCols(2);
  }
  ProcessPrior prior;
  prior.basis = basis;
  prior.floor = floor;
  prior.mean = luminance * weights / weights.sum();
  prior.luminance = Components(luminance, weights, prior.mean, metric, counts.luminance);
  // Chroma has no sign: swapping channels turns it round. So its mean is zero.
  prior.chroma = Components(chroma, Eigen::VectorXd::Ones(2 * n),
                            Eigen::VectorXd::Zero(basis.size()), metric, counts.chroma);
  if (prior.chroma.cols() == 0) {  // all grey: nothing was learned of colours but that
    prior.chroma = Eigen::VectorXd::Constant(basis.size(), kGreyTint);
  }
  return prior;
}

// Squares of what components of the other fields leave of `curve`, added up.
void AddLeftover(const Eigen::MatrixXd& components, const Eigen::VectorXd& curve,
                 const Eigen::MatrixXd& metric, Eigen::VectorXd* squares) {
  const Eigen::MatrixXd weighted = metric * components;
  Eigen::MatrixXd normal = components.transpose() * weighted;
  normal.diagonal().array() += kLeftoverNoise * kLeftoverNoise;
  const Eigen::VectorXd weights = normal.llt().solve(weighted.transpose() * curve);
  *squares += (curve - components * weights).cwiseAbs2();
}

// A root mean square over fields, smoothed over neighbouring coefficients of the same harmonic.
Eigen::VectorXd SmoothSpread(const ProcessBasis& basis, const Eigen::VectorXd& mean_squares,
                             const Eigen::MatrixXd& metric) {
  Eigen::VectorXd spread(basis.size());
  for (int h = 0; h < basis.theta_h_knots(); ++h) {
    for (int d = 0; d < basis.theta_d_knots(); ++d) {
      for (int k = 0; k < ProcessBasis::kHarmonics; ++k) {
        double sum = 0;
        double weight = 0;
        for (int i = std::max(h - 1, 0); i <= std::min(h + 1, basis.theta_h_knots() - 1); ++i) {
          for (int j = std::max(d - 1, 0); j <= std::min(d + 1, basis.theta_d_knots() - 1); ++j) {
            const int index = basis.Index(i, j, k);
            if (metric(index, index) < kSeen) continue;
            sum += mean_squares[index];
            weight += 1;
          }
        }
        spread[basis.Index(h, d, k)] = weight > 0 ? std::sqrt(sum / weight) : 0;
      }
    }
  }
  return spread;
}

}  // namespace

ProcessPrior LearnProcess(std::span<const MaterialField* const> fields, const ProcessBasis& basis,
                          double floor, const Eigen::MatrixXd& metric,
                          const ComponentCounts& counts) {
  ProcessPrior prior = LearnComponents(fields, basis, floor, metric, counts);
  Eigen::VectorXd luminance = Eigen::VectorXd::Zero(basis.size());
  Eigen::VectorXd chroma = Eigen::VectorXd::Zero(basis.size());
  const std::size_t folds = std::min<std::size_t>(kSpreadFolds, fields.size());
  for (std::size_t fold = 0; fold < folds; ++fold) {
    std::vector<const MaterialField*> others;
    for (std::size_t m = 0; m < fields.size(); ++m) {
      if (m % folds != fold) others.push_back(fields[m]);
    }
    const ProcessPrior of_others = LearnComponents(others, basis, floor, metric, counts);
    for (std::size_t m = fold; m < fields.size(); m += folds) {
      const Series series = SeriesOf(fields[m]->coefficients.leftCols(kChannels));
      AddLeftover(of_others.luminance, series.col(0) - of_others.mean, metric, &luminance);
      AddLeftover(of_others.chroma, series.col(1), metric, &chroma);
      AddLeftover(of_others.chroma, series.col(2), metric, &chroma);
    }
  }
  const auto n = static_cast<double>(fields.size());
  prior.stationary_luminance = SmoothSpread(basis, luminance / n, metric);
  prior.stationary_chroma = SmoothSpread(basis, chroma / (2 * n), metric);
  return prior;
}

}  // namespace gonio
