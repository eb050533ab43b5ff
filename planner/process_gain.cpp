// SPDX-License-Identifier: Apache-2.0
#include "planner/process_gain.h"

#include <algorithm>
#include <cmath>

#include "core/check.h"
#include "core/units.h"
#include "fitting/generalised_log.h"

namespace gonio {
namespace {

// Of the coarse candidates, so many lead to a closer look around them.
constexpr int kLeaders = 6;
constexpr int kReach = 2;  // raster cells around a leader
// Of z: what is known better counts as known so well. Spreads can be 0 without model error.
constexpr double kLeastSpread = 1e-3;

// The objective's quantity at z = glog(f_r).
double Quantity(Objective objective, double z, double cosine, double floor) {
  if (objective == Objective::kRelative) return z;
  return std::log1p(std::max(FromGeneralisedLog(z, floor), 0.0) * cosine);
}

// How much it changes with z, on average within a standard deviation: where little is known yet, a
// dark prediction must not make light of what may be bright.
double Sensitivity(Objective objective, double z, double sd, double cosine, double floor) {
  const double reach = std::max(sd, kLeastSpread);
  return (Quantity(objective, z + reach, cosine, floor) -
          Quantity(objective, z - reach, cosine, floor)) /
         (2 * reach);
}

// The diagonal of phi' matrix phi, of a symmetric matrix: twice its upper half does, at half the
// cost. Single precision, since no more than six digits matter to a choice.
Eigen::VectorXf DiagonalOf(const Eigen::MatrixXf& matrix, const Eigen::MatrixXf& phi) {
  Eigen::MatrixXf half = 2 * matrix;
  half.diagonal() = matrix.diagonal();
  const Eigen::MatrixXf product = half.triangularView<Eigen::Upper>() * phi;
  return product.cwiseProduct(phi).colwise().sum().transpose();
}

}  // namespace

ProcessGain::ProcessGain(std::vector<Candidate> candidates, const ProcessGainOptions& options)
    : candidates_(std::move(candidates)),
      options_(options),
      targets_(SpreadDirections(options.targets, options.max_polar)),
      parts_(candidates_, options_.parts) {
  for (const Candidate& candidate : candidates_) {
    rows_ = std::max(rows_, candidate.row + 1);
    columns_ = std::max(columns_, candidate.column + 1);
  }
  cells_.resize(static_cast<std::size_t>(rows_) * columns_);
  for (std::size_t i = 0; i < candidates_.size(); ++i) {
    const Candidate& candidate = candidates_[i];
    cells_[static_cast<std::size_t>(candidate.row) * columns_ + candidate.column].push_back(
        static_cast<int>(i));
  }
  // Every so-many-th candidate in an order that jumps about.
  const double step = std::max(1.0, static_cast<double>(candidates_.size()) / options_.coarse);
  for (double at = 0.5 * step; at < static_cast<double>(candidates_.size()); at += step) {
    coarse_.push_back(static_cast<int>(at));
  }
}

void ProcessGain::SetModel(std::shared_ptr<const ProcessModel> model) {
  if (model == model_) return;
  model_ = std::move(model);
  const std::size_t groups = model_->groups().size();
  features_.assign(groups, {});
  on_coarse_.assign(groups, {});
  on_targets_.assign(groups, {});
  const auto count = static_cast<Eigen::Index>(candidates_.size());
  const auto targets = static_cast<Eigen::Index>(targets_.size());
  for (std::size_t g = 0; g < groups; ++g) {
    features_[g].resize(model_->groups()[g].size, count);
    on_coarse_[g].resize(model_->groups()[g].size, static_cast<Eigen::Index>(coarse_.size()));
    on_targets_[g].resize(model_->groups()[g].size, targets);
  }
  candidate_means_.resize(kChannels, count);
  target_means_.resize(kChannels, targets);
  for (Eigen::Index i = 0; i < count; ++i) {
    const ProcessModel::Place place = model_->At(candidates_[i].angles);
    candidate_means_.col(i) = place.mean;
    for (std::size_t g = 0; g < groups; ++g) features_[g].col(i) = place.features[g].cast<float>();
  }
  for (Eigen::Index i = 0; i < targets; ++i) {
    const ProcessModel::Place place = model_->At(targets_[i].angles);
    target_means_.col(i) = place.mean;
    for (std::size_t g = 0; g < groups; ++g) {
      on_targets_[g].col(i) = place.features[g].cast<float>();
    }
  }
  for (std::size_t g = 0; g < groups; ++g) {
    for (std::size_t k = 0; k < coarse_.size(); ++k) {
      on_coarse_[g].col(static_cast<Eigen::Index>(k)) = features_[g].col(coarse_[k]);
    }
  }
}

void ProcessGain::Learn(std::shared_ptr<const ProcessModel> model,
                        const ProcessPosterior& posterior, const ProcessOptions& process) {
  SetModel(std::move(model));
  for (int s = 0; s < kChannels; ++s) weights_[s] = posterior.weights()[s].cast<float>();
  model_error_ = process.model_error;
  repeatability_ = process.repeatability;
  groups_.resize(model_->groups().size());
  for (std::size_t g = 0; g < groups_.size(); ++g) {
    groups_[g].covariance = posterior.groups()[g].covariance;
  }
  SetObjective(posterior, process);
  ScoreCoarse();
}

void ProcessGain::SetObjective(const ProcessPosterior& posterior, const ProcessOptions& process) {
  const auto targets = static_cast<Eigen::Index>(targets_.size());
  Eigen::Vector3d white;  // variance that no weight explains
  Eigen::MatrixXd series = target_means_;
  Eigen::MatrixXd variance(kChannels, targets);
  for (std::size_t g = 0; g < groups_.size(); ++g) {
    const ProcessModel::Group& group = model_->groups()[g];
    const Eigen::MatrixXf covariance = posterior.groups()[g].covariance.cast<float>();
    // What is known for certain may come out a little below nothing.
    const Eigen::VectorXd v = DiagonalOf(covariance, on_targets_[g]).cast<double>().cwiseMax(0);
    for (int s = group.first_series; s < group.first_series + group.series; ++s) {
      series.row(s) += (weights_[s].transpose() * on_targets_[g]).cast<double>();
      variance.row(s) = v.transpose();
      white[s] = posterior.groups()[g].scale * process.model_error * process.model_error;
    }
  }
  const Eigen::Matrix3d& t = model_->transform();
  const Eigen::Matrix3d squares = t.cwiseAbs2();
  Eigen::MatrixXd on_series(kChannels, targets);  // d error / d variance, but for a factor
  total_ = predicted_error_ = floor_error_ = 0;
  for (Eigen::Index i = 0; i < targets; ++i) {
    const Eigen::Vector3d z = t.transpose() * series.col(i);
    const Eigen::Vector3d least = squares.transpose() * white;
    const Eigen::Vector3d v = squares.transpose() * variance.col(i) + least;
    Eigen::Vector3d slope;
    for (int c = 0; c < kChannels; ++c) {
      const double sd = std::sqrt(v[c]);
      const double g =
          Sensitivity(options_.objective, z[c], sd, targets_[i].cosine, model_->floor());
      const double weight = targets_[i].weight / kChannels * g;
      // How fast the mean absolute error falls with variance. Summing variances instead would send
      // most of the first poses into the highlight, where little is known of little.
      slope[c] = weight / std::max(sd, kLeastSpread);
      // Mean absolute value of a Gaussian: sqrt(2 / pi) sigma.
      predicted_error_ += weight * std::sqrt(2 / kPi) * sd;
      floor_error_ += weight * std::sqrt(2 / kPi * least[c]);
    }
    on_series.col(i) = squares * slope;
    total_ += on_series.col(i).dot(variance.col(i));
  }
  predicted_error_ *= model_->error_margin();
  floor_error_ *= model_->error_margin();
  for (std::size_t g = 0; g < groups_.size(); ++g) {
    const ProcessModel::Group& group = model_->groups()[g];
    const Eigen::VectorXd weight =
        on_series.middleRows(group.first_series, group.series).colwise().sum().transpose();
    const Eigen::MatrixXf scaled = on_targets_[g] * weight.cwiseSqrt().cast<float>().asDiagonal();
    Eigen::MatrixXf objective = Eigen::MatrixXf::Zero(group.size, group.size);
    objective.selfadjointView<Eigen::Lower>().rankUpdate(scaled);
    objective.triangularView<Eigen::StrictlyUpper>() = objective.transpose();
    groups_[g].objective = objective.cast<double>();
  }
}

void ProcessGain::ScoreCoarse() {
  for (std::size_t g = 0; g < groups_.size(); ++g) {
    GroupState& state = groups_[g];
    const Eigen::MatrixXf& phi = on_coarse_[g];
    const Eigen::MatrixXf p = state.covariance.cast<float>();
    const Eigen::MatrixXf m = p * (state.objective.cast<float>() * p);
    state.taught = m.cast<double>();
    state.variance = DiagonalOf(p, phi);
    state.numerator = DiagonalOf(m, phi);
    state.noise.resize(phi.cols());
  }
  for (std::size_t k = 0; k < coarse_.size(); ++k) {
    const std::vector<double> noise = NoiseVariance(coarse_[k], 1);
    for (std::size_t g = 0; g < groups_.size(); ++g) {
      groups_[g].noise[static_cast<Eigen::Index>(k)] = static_cast<float>(noise[g]);
    }
  }
}

std::vector<double> ProcessGain::NoiseVariance(int candidate, int frames) const {
  Eigen::Vector3d series = candidate_means_.col(candidate);
  for (std::size_t g = 0; g < groups_.size(); ++g) {
    const ProcessModel::Group& group = model_->groups()[g];
    for (int s = group.first_series; s < group.first_series + group.series; ++s) {
      series[s] += features_[g].col(candidate).dot(weights_[s]);
    }
  }
  const Eigen::Matrix3d& t = model_->transform();
  const Rgb f_r = model_->ReflectanceOf(t.transpose() * series);
  const Rgb sigma = Noise(candidates_[candidate].directions, f_r);
  Eigen::Vector3d noise;
  for (int c = 0; c < kChannels; ++c) {
    const double sensor = sigma[c] * GeneralisedLogSlope(f_r[c], model_->floor());
    noise[c] = sensor * sensor / frames + model_error_ * model_error_;
  }
  const Eigen::Vector3d common = t.rowwise().sum() * repeatability_;
  const Eigen::Vector3d all = t.cwiseAbs2() * noise + common.cwiseAbs2();
  std::vector<double> variances;
  for (const ProcessModel::Group& group : model_->groups()) {
    variances.push_back(all.segment(group.first_series, group.series).mean());
  }
  return variances;
}

Rgb ProcessGain::Noise(const DirectionPair& pair, const Rgb& f_r) const {
  if (options_.noise) return options_.noise(pair, f_r);
  const double floor = options_.absolute_noise * options_.absolute_noise;
  return ((options_.relative_noise * f_r).square() + floor).sqrt();
}

std::vector<int> ProcessGain::Near(int candidate) const {
  const Candidate& centre = candidates_[candidate];
  std::vector<int> near;
  for (int row = std::max(0, centre.row - kReach); row <= std::min(rows_ - 1, centre.row + kReach);
       ++row) {
    for (int column = std::max(0, centre.column - kReach);
         column <= std::min(columns_ - 1, centre.column + kReach); ++column) {
      const auto& cell = cells_[static_cast<std::size_t>(row) * columns_ + column];
      near.insert(near.end(), cell.begin(), cell.end());
    }
  }
  return near;
}

double ProcessGain::ImageGain(const std::vector<int>& parts, int frames) const {
  const auto count = std::ssize(parts);
  std::vector<std::vector<double>> noise;
  for (const int part : parts) noise.push_back(NoiseVariance(part, frames));
  double gain = 0;
  for (std::size_t g = 0; g < groups_.size(); ++g) {
    const ProcessModel::Group& group = model_->groups()[g];
    const double own = model_error_ * model_error_ *
                       model_->transform()
                           .cwiseAbs2()
                           .rowwise()
                           .sum()
                           .segment(group.first_series, group.series)
                           .mean();
    Eigen::MatrixXd phi(features_[g].rows(), count);
    Eigen::VectorXd shared(count);
    for (Eigen::Index k = 0; k < count; ++k) {
      phi.col(k) = features_[g].col(parts[k]).cast<double>();
      shared[k] = std::sqrt(std::max(noise[k][g] - own, 0.0));
    }
    Eigen::MatrixXd expected = phi.transpose() * (groups_[g].covariance * phi);
    expected += shared * shared.transpose();
    expected.diagonal().array() += own + 1e-9;
    const Eigen::MatrixXd drop = phi.transpose() * (groups_[g].taught * phi);
    gain += expected.llt().solve(drop).trace();
  }
  return gain;
}

std::vector<double> ProcessGain::GainsOf(const std::vector<int>& candidates, int frames) const {
  const auto count = static_cast<Eigen::Index>(candidates.size());
  std::vector<double> gains(candidates.size(), 0);
  if (!(total_ > 0)) return gains;
  if (parts_.any()) {
    for (Eigen::Index k = 0; k < count; ++k) {
      gains[k] = ImageGain(parts_.Of(candidates[k]), frames) / total_;
    }
    return gains;
  }
  std::vector<Eigen::VectorXf> variances;
  std::vector<Eigen::VectorXf> numerators;
  for (std::size_t g = 0; g < groups_.size(); ++g) {
    Eigen::MatrixXf phi(features_[g].rows(), count);
    for (Eigen::Index k = 0; k < count; ++k) phi.col(k) = features_[g].col(candidates[k]);
    variances.push_back(DiagonalOf(groups_[g].covariance.cast<float>(), phi));
    numerators.push_back(DiagonalOf(groups_[g].taught.cast<float>(), phi));
  }
  for (Eigen::Index k = 0; k < count; ++k) {
    const std::vector<double> noise = NoiseVariance(candidates[k], frames);
    for (std::size_t g = 0; g < groups_.size(); ++g) {
      gains[k] += numerators[g][k] / (variances[g][k] + noise[g]);
    }
    gains[k] /= total_;
  }
  return gains;
}

ProcessGain::Choice ProcessGain::Best(const std::vector<bool>& spent, const Worth& worth) const {
  std::vector<std::pair<double, int>> scores;
  for (std::size_t k = 0; k < coarse_.size(); ++k) {
    const int candidate = coarse_[k];
    if (spent[candidate]) continue;
    double gain = 0;
    for (std::size_t g = 0; g < groups_.size(); ++g) {
      const auto i = static_cast<Eigen::Index>(k);
      gain += groups_[g].numerator[i] / (groups_[g].variance[i] + groups_[g].noise[i]);
    }
    if (total_ > 0) gain /= total_;
    scores.emplace_back(worth(candidates_[candidate], gain), candidate);
  }
  const std::size_t leaders = std::min<std::size_t>(kLeaders, scores.size());
  std::partial_sort(scores.begin(), scores.begin() + static_cast<std::ptrdiff_t>(leaders),
                    scores.end(), [](const auto& a, const auto& b) {
                      return a.first != b.first ? a.first > b.first : a.second < b.second;
                    });
  std::vector<int> near;
  std::vector<bool> passed = spent;
  for (std::size_t k = 0; k < leaders; ++k) {
    for (const int candidate : Near(scores[k].second)) {
      if (!passed[candidate]) near.push_back(candidate);
      passed[candidate] = true;
    }
  }
  for (const int candidate : parts_.scouts()) {
    if (!passed[candidate]) near.push_back(candidate);
  }
  Choice best;
  const std::vector<double> gains = GainsOf(near);
  for (std::size_t k = 0; k < near.size(); ++k) {
    const double score = worth(candidates_[near[k]], gains[k]);
    if (best.candidate < 0 || score > best.score) best = {near[k], gains[k], score};
  }
  if (best.candidate >= 0) return best;
  const auto left = std::find(spent.begin(), spent.end(), false);  // none of the coarse ones
  if (left == spent.end()) return best;
  const int candidate = static_cast<int>(left - spent.begin());
  const double gain = GainOf(candidate);
  return {candidate, gain, worth(candidates_[candidate], gain)};
}

void ProcessGain::Suppose(int candidate, int frames) {
  if (!parts_.any()) return SupposeOne(candidate, frames);
  for (const int part : parts_.Of(candidate)) SupposeOne(part, frames);
}

void ProcessGain::SupposeOne(int candidate, int frames) {
  const std::vector<double> noise = NoiseVariance(candidate, frames);
  for (std::size_t g = 0; g < groups_.size(); ++g) {
    GroupState& state = groups_[g];
    const Eigen::VectorXd phi = features_[g].col(candidate).cast<double>();
    const Eigen::VectorXd p = state.covariance * phi;
    const Eigen::VectorXd q = state.covariance * (state.objective * p);
    const double s = phi.dot(p) + noise[g];
    const double r = p.dot(state.objective * p);
    state.covariance -= p * p.transpose() / s;
    state.taught += (-p * q.transpose() - q * p.transpose() + (r / s) * p * p.transpose()) / s;
    const Eigen::VectorXf on_p = on_coarse_[g].transpose() * p.cast<float>();
    const Eigen::VectorXf on_q = on_coarse_[g].transpose() * q.cast<float>();
    const auto sf = static_cast<float>(s);
    state.variance -= on_p.cwiseAbs2() / sf;
    state.numerator +=
        (static_cast<float>(r) / sf * on_p.cwiseAbs2() - 2 * on_p.cwiseProduct(on_q)) / sf;
  }
}

}  // namespace gonio
