// SPDX-License-Identifier: Apache-2.0
#include "fitting/process_model.h"

#include <algorithm>

#include "fitting/generalised_log.h"

namespace gonio {
namespace {

constexpr int kStationaryLuminance = 180;
constexpr int kStationaryChroma = 100;

// Learned components with the stationary ones beside them.
Eigen::MatrixXd Beside(const Eigen::MatrixXd& learned, const Eigen::MatrixXd& stationary) {
  Eigen::MatrixXd all(learned.rows(), learned.cols() + stationary.cols());
  all << learned, stationary;
  return all;
}

}  // namespace

ProcessModel::ProcessModel(const ProcessPrior& prior)
    : floor_(prior.floor),
      transform_(LuminanceAndChroma()),
      calibration_(prior.calibration),
      error_margin_(prior.error_margin),
      basis_(prior.basis),
      mean_(Eigen::MatrixXd::Zero(prior.basis.size(), kChannels)) {
  mean_.col(0) = prior.mean;
  components_ = {Beside(prior.luminance, StationaryComponents(basis_, prior.stationary_luminance,
                                                              kStationaryLuminance)),
                 Beside(prior.chroma,
                        StationaryComponents(basis_, prior.stationary_chroma, kStationaryChroma))};
  groups_ = {{.first_series = 0,
              .series = 1,
              .learned = static_cast<int>(prior.luminance.cols()),
              .size = static_cast<int>(components_[0].cols())},
             {.first_series = 1,
              .series = 2,
              .learned = static_cast<int>(prior.chroma.cols()),
              .size = static_cast<int>(components_[1].cols())}};
}

Rgb ProcessModel::ReflectanceOf(const Eigen::Vector3d& z) const {
  Rgb f_r;
  for (int c = 0; c < kChannels; ++c) f_r[c] = std::max(FromGeneralisedLog(z[c], floor_), 0.0);
  return f_r;
}

ProcessModel::Place ProcessModel::At(const HalfDiff& angles) const {
  const ProcessBasis::Terms terms = basis_.At(angles);
  Place place;
  for (int s = 0; s < kChannels; ++s) place.mean[s] = terms.Of(mean_.col(s));
  for (std::size_t g = 0; g < groups_.size(); ++g) {
    place.features[g] = terms.RowOf(components_[g]);
  }
  return place;
}

Eigen::MatrixXd ProcessModel::FieldOf(const std::array<Eigen::VectorXd, kChannels>& weights) const {
  Eigen::MatrixXd field = mean_;
  for (std::size_t g = 0; g < groups_.size(); ++g) {
    const Group& group = groups_[g];
    for (int s = group.first_series; s < group.first_series + group.series; ++s) {
      field.col(s) += components_[g] * weights[s];
    }
  }
  return field;
}

Eigen::Vector3d ProcessModel::SeriesAt(const HalfDiff& angles, const Eigen::MatrixXd& field) const {
  const ProcessBasis::Terms terms = basis_.At(angles);
  Eigen::Vector3d series;
  for (int s = 0; s < kChannels; ++s) series[s] = terms.Of(field.col(s));
  return series;
}

}  // namespace gonio
