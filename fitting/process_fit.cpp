// SPDX-License-Identifier: Apache-2.0
#include "fitting/process_fit.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/check.h"
#include "core/error.h"
#include "fitting/generalised_log.h"

namespace gonio {
namespace {

// Of a standard normal x.
double UpperTail(double x) { return 0.5 * std::erfc(x / std::sqrt(2.0)); }

// u with P(x < u | x > a) = probability.
double QuantileBeyond(double a, double probability) {
  constexpr double kFar = 30;  // the tail is an exponential there, and soon too small a number
  if (a > kFar) return a - std::log(1 - probability) / a;
  const double beyond = (1 - probability) * UpperTail(a);
  double low = a;
  double high = std::max(a, 0.0) + 10;
  for (int i = 0; i < 60; ++i) {
    const double middle = 0.5 * (low + high);
    (UpperTail(middle) > beyond ? low : high) = middle;
  }
  return low;
}

}  // namespace

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

Bounds NarrowestBounds(double mean, double sd, double least, double probability) {
  if (!(sd > 0)) return {std::max(mean, least), std::max(mean, least)};
  const double a = (least - mean) / sd;
  const double reach = CentralQuantile(probability * UpperTail(a));
  if (a < -reach) return {mean - reach * sd, mean + reach * sd};
  return {least, mean + sd * QuantileBeyond(a, probability)};
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

Eigen::Vector3d ProcessFit::MeanAt(const HalfDiff& angles) const {
  return model_->transform().transpose() * model_->SeriesAt(angles, field_);
}

std::optional<Rgb> ProcessFit::Eval(const HalfDiff& angles) const {
  double cos_i = 0;
  double cos_o = 0;
  Cosines(angles, &cos_i, &cos_o);
  if (!(cos_i > 0 && cos_o > 0)) return std::nullopt;
  return model_->ReflectanceOf(MeanAt(angles));
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
  Prediction prediction;
  prediction.f_r = model_->ReflectanceOf(MeanAt(angles));
  for (int c = 0; c < kChannels; ++c) {
    prediction.sigma[c] = spread[c] / GeneralisedLogSlope(prediction.f_r[c], model_->floor());
  }
  return prediction;
}

Interval ProcessFit::PredictInterval(const HalfDiff& angles, double probability) const {
  GONIO_CHECK(probability > 0 && probability < 1, "a probability");
  const Rgb spread = WideningAt(model_->calibration(), probability) * SpreadAt(angles);
  const Eigen::Vector3d z = MeanAt(angles);
  Eigen::Vector3d low;
  Eigen::Vector3d high;
  for (int c = 0; c < kChannels; ++c) {
    const Bounds bounds =
        NarrowestBounds(z[c], spread[c], GeneralisedLog(0, model_->floor()), probability);
    low[c] = bounds.low;
    high[c] = bounds.high;
  }
  return {model_->ReflectanceOf(low), model_->ReflectanceOf(high)};
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
