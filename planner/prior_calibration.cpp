// SPDX-License-Identifier: Apache-2.0
#include "planner/prior_calibration.h"

#include <algorithm>
#include <cmath>
#include <memory>
#include <utility>

#include "core/check.h"
#include "core/task_pool.h"
#include "core/units.h"
#include "fitting/generalised_log.h"
#include "fitting/process_fit.h"
#include "planner/process_planner.h"
#include "planner/spread_directions.h"

namespace gonio {
namespace {

constexpr double kProbabilities[] = {0.5, 0.8, 0.9, 0.95, 0.99};

// Value and what it counts.
using Weighted = std::pair<double, double>;

struct Trial {
  std::vector<Weighted> deviations;  // |z - predicted| / standard deviation
  std::vector<double> error_ratios;  // true over expected
};

double WeightedQuantile(std::vector<Weighted> values, double share) {
  GONIO_CHECK(!values.empty(), "a quantile of something");
  std::sort(values.begin(), values.end());
  double total = 0;
  for (const Weighted& value : values) total += value.second;
  double sum = 0;
  for (const Weighted& value : values) {
    sum += value.second;
    if (sum >= share * total) return value.first;
  }
  return values.back().first;
}

// Compares a fit with the truth at the directions, and its error with what was expected.
void Judge(const Brdf& truth, const ProcessFit& fit, double floor, double expected,
           std::span<const SpreadDirection> directions, Trial* trial) {
  double error = 0;
  double weight = 0;
  for (const SpreadDirection& at : directions) {
    const std::optional<Rgb> f = truth.Eval(at.angles);
    const std::optional<Rgb> g = fit.Eval(at.angles);
    if (!f || !g || !f->isFinite().all()) continue;
    const Rgb spread = fit.SpreadAt(at.angles);
    for (int c = 0; c < kChannels; ++c) {
      const double true_f = std::max((*f)[c], 0.0);
      const double off = GeneralisedLog(true_f, floor) - GeneralisedLog((*g)[c], floor);
      trial->deviations.emplace_back(std::abs(off) / spread[c], at.weight);
      error +=
          at.weight * std::abs(std::log1p(true_f * at.cosine) - std::log1p((*g)[c] * at.cosine));
      weight += at.weight;
    }
  }
  if (weight > 0 && expected > 0) trial->error_ratios.push_back(error / weight / expected);
}

Trial TryOn(const TrainingMaterial& material, const std::shared_ptr<const ProcessPrior>& prior,
            const CalibrationOptions& options, std::span<const SpreadDirection> directions) {
  ProcessPlannerOptions plan;
  plan.max_poses = options.poses.back();
  plan.prior = prior;
  const auto known = [&](const DirectionPair& pair) {
    const std::optional<Rgb> f = material.brdf->Eval(pair);
    return f && f->isFinite().all();
  };
  const std::vector<Candidate> candidates =
      MakeCandidates({.phi_choices = 2, .phi_span = kPi}, known);
  if (candidates.empty()) return {};
  ProcessPlanner planner(candidates, plan);
  ProcessGain expecting({candidates.front()}, plan.gain);
  const auto model = std::make_shared<const ProcessModel>(*prior);
  std::vector<ProcessReading> readings;
  Trial trial;
  while (const std::optional<Proposal> next = planner.Next()) {
    BrdfSample sample;
    sample.directions = next->directions;
    sample.f_r = *material.brdf->Eval(next->directions);
    sample.sigma = (plan.gain.relative_noise * sample.f_r).max(plan.gain.absolute_noise);
    planner.Observe(*next, sample);
    readings.push_back(ToReading(*model, sample));
    const auto count = static_cast<int>(readings.size());
    if (!std::binary_search(options.poses.begin(), options.poses.end(), count)) continue;
    const ProcessPosterior posterior(*model, readings, plan.process);
    expecting.Learn(model, posterior, plan.process);
    Judge(*material.brdf, ProcessFit(model, posterior, plan.process), prior->floor,
          expecting.predicted_error(), directions, &trial);
  }
  return trial;
}

// The sessions of one fold, each into its material's place.
void TryFold(std::span<const TrainingMaterial> materials, int fold, const LearnOptions& learn,
             const CalibrationOptions& options, std::span<const SpreadDirection> directions,
             std::vector<Trial>* trials) {
  std::vector<TrainingMaterial> others;
  std::vector<std::size_t> left_out;
  for (std::size_t i = 0; i < materials.size(); ++i) {
    if (static_cast<int>(i % static_cast<std::size_t>(options.folds)) == fold) {
      left_out.push_back(i);
    } else {
      others.push_back(materials[i]);
    }
  }
  LearnOptions process_only = learn;
  process_only.lobes = false;
  const auto uncalibrated =
      std::make_shared<ProcessPrior>(*LearnPrior(others, process_only).process);
  uncalibrated->error_margin = 1;
  ForEachTask(left_out.size(), learn.threads, {}, [&](std::size_t k) {
    const std::size_t i = left_out[k];
    (*trials)[i] = TryOn(materials[i], uncalibrated, options, directions);
  });
}

}  // namespace

Prior LearnCalibratedPrior(std::span<const TrainingMaterial> materials, const LearnOptions& learn,
                           const CalibrationOptions& options) {
  Prior prior = LearnPrior(materials, learn);
  if (static_cast<int>(materials.size()) < kLeastToCalibrate) return prior;
  const std::vector<SpreadDirection> directions =
      SpreadDirections(options.directions, RadFromDeg(80));
  std::vector<Trial> trials(materials.size());
  for (int fold = 0; fold < options.folds; ++fold) {
    TryFold(materials, fold, learn, options, directions, &trials);
  }
  std::vector<Weighted> deviations;
  std::vector<Weighted> ratios;
  for (const Trial& trial : trials) {
    deviations.insert(deviations.end(), trial.deviations.begin(), trial.deviations.end());
    for (const double ratio : trial.error_ratios) ratios.emplace_back(ratio, 1);
  }
  auto calibrated = std::make_shared<ProcessPrior>(*prior.process);
  for (const double probability : kProbabilities) {
    calibrated->calibration.push_back(
        {probability, WeightedQuantile(deviations, probability) / CentralQuantile(probability)});
  }
  calibrated->error_margin = WeightedQuantile(ratios, options.share);
  prior.process = std::move(calibrated);
  return prior;
}

}  // namespace gonio
