// SPDX-License-Identifier: Apache-2.0
#include "fitting/process_fit.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/check.h"
#include "core/error.h"
#include "fitting/generalised_log.h"

namespace gonio {

// By bisection: erf has no inverse in the library.
double CentralQuantile(double probability) {
  double low = 0;
  double high = 40;
  for (int i = 0; i < 100; ++i) {
    const double middle = 0.5 * (low + high);
    (std::erf(middle / std::sqrt(2.0)) < probability ? low : high) = middle;
  }
  return low;
}

double WideningAt(const std::vector<Calibration>& calibration, double probability) {
  if (calibration.empty()) return 1;
  if (probability <= calibration.front().probability) return calibration.front().widening;
  for (std::size_t i = 1; i < calibration.size(); ++i) {
    const Calibration& above = calibration[i];
    if (probability > above.probability) continue;
    const Calibration& below = calibration[i - 1];
    const double share =
        (probability - below.probability) / (above.probability - below.probability);
    return below.widening + share * (above.widening - below.widening);
  }
  return calibration.back().widening;
}

ProcessFit::ProcessFit(std::shared_ptr<const ProcessModel> model, const ProcessPosterior& posterior,
                       const ProcessOptions& options)
    : model_(std::move(model)),
      field_(model_->FieldOf(posterior.weights())),
      groups_(posterior.groups()),
      model_error_(options.model_error) {}

Eigen::Array3d ProcessFit::MeanAt(const HalfDiff& angles) const {
  return (model_->transform().transpose() * model_->SeriesAt(angles, field_)).array();
}

std::optional<Rgb> ProcessFit::Eval(const HalfDiff& angles) const {
  double cos_i = 0;
  double cos_o = 0;
  Cosines(angles, &cos_i, &cos_o);
  if (!(cos_i > 0 && cos_o > 0)) return std::nullopt;
  const Eigen::Array3d z = MeanAt(angles);
  Rgb f_r;
  for (int c = 0; c < kChannels; ++c) {
    f_r[c] = std::max(FromGeneralisedLog(z[c], model_->floor()), 0.0);
  }
  return f_r;
}

Rgb ProcessFit::SpreadAt(const HalfDiff& angles) const {
  const ProcessModel::Place place = model_->At(angles);
  Eigen::Vector3d series;
  for (std::size_t g = 0; g < groups_.size(); ++g) {
    const ProcessModel::Group& group = model_->groups()[g];
    const double variance = place.features[g].dot(groups_[g].covariance * place.features[g]);
    series.segment(group.first_series, group.series)
        .setConstant(variance + groups_[g].scale * model_error_ * model_error_);
  }
  return (model_->transform().transpose().cwiseAbs2() * series).array().sqrt();
}

Prediction ProcessFit::Predict(const HalfDiff& angles) const {
  const Rgb spread = SpreadAt(angles);
  const Eigen::Array3d z = MeanAt(angles);
  Prediction prediction;
  for (int c = 0; c < kChannels; ++c) {
    prediction.f_r[c] = std::max(FromGeneralisedLog(z[c], model_->floor()), 0.0);
    prediction.sigma[c] = spread[c] / GeneralisedLogSlope(prediction.f_r[c], model_->floor());
  }
  return prediction;
}

Interval ProcessFit::PredictInterval(const HalfDiff& angles, double probability) const {
  GONIO_CHECK(probability > 0 && probability < 1, "a probability");
  const double reach =
      CentralQuantile(probability) * WideningAt(model_->calibration(), probability);
  const Rgb spread = SpreadAt(angles);
  const Eigen::Array3d z = MeanAt(angles);
  Interval interval;
  for (int c = 0; c < kChannels; ++c) {
    const double floor = model_->floor();
    interval.low[c] = std::max(FromGeneralisedLog(z[c] - reach * spread[c], floor), 0.0);
    interval.high[c] = std::max(FromGeneralisedLog(z[c] + reach * spread[c], floor), 0.0);
  }
  return interval;
}

ProcessReading ToReading(const ProcessModel& model, const BrdfSample& sample) {
  return {model.At(ToHalfDiff(sample.directions)), sample.f_r, sample.sigma};
}

std::unique_ptr<ProcessFit> FitProcess(std::span<const BrdfSample> samples, const Prior& prior,
                                       const ProcessOptions& options) {
  options.Check();
  if (!prior.process) {
    throw ConfigError(
        fmt::format("prior {}: has no process; learn one with gonio prior learn", prior.name));
  }
  const auto model = std::make_shared<const ProcessModel>(*prior.process);
  std::vector<ProcessReading> readings;
  for (const BrdfSample& sample : samples) {
    if (sample.sigma.isFinite().any()) readings.push_back(ToReading(*model, sample));
  }
  if (readings.empty()) {
    throw ConfigError("nothing to fit: no sample has a channel with a finite sigma");
  }
  return std::make_unique<ProcessFit>(model, ProcessPosterior(*model, readings, options), options);
}

}  // namespace gonio
