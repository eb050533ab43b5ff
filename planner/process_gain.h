// SPDX-License-Identifier: Apache-2.0
// How much a measurement would teach: the expected drop of predictive variance.

#pragma once

#include <Eigen/Core>
#include <array>
#include <functional>
#include <memory>
#include <vector>

#include "fitting/process_fit.h"
#include "planner/candidates.h"
#include "planner/image_parts.h"
#include "planner/information_gain.h"
#include "planner/planner.h"
#include "planner/spread_directions.h"

namespace gonio {

struct ProcessGainOptions {
  Objective objective = Objective::kMale;
  double max_polar = 1.3962634;   // rad (80 deg): directions nearer to the horizon do not count
  PartsOf parts = {};             // what else the image of a pose shows
  ExpectedNoise noise = {};       // of a reading; if empty:
  double relative_noise = 0.015;  // > 0: its relative sigma
  double absolute_noise = 5e-4;   // 1/sr, > 0: the same of a dark sample
  int targets = 1200;             // directions the objective is summed over, > 0
  int coarse = 1500;              // candidates scored before those around the best are, > 0
};

// Scores candidates under the Gaussian posterior of a process (D. MacKay, "Information-Based
// Objective Functions for Active Data Selection", 1992; the criterion is Bayesian I-optimality):
//
//   gain(x) = sum over series s of  phi' P A_s P phi / (phi' P phi + r)
//
// phi: features at x; P: covariance of the weights; A_s: sum over the target directions of
// weight x sensitivity of the objective to z / standard deviation of z x phi phi', so that it is
// the expected absolute error that falls fastest; r: variance of a reading. A thinned set of
// candidates is scored first, then all those near its best.
//
// Of an image with several samples, phi holds a column for each, and phi' P phi + r is a matrix:
// all of r but the model error is one draw for the image, which its parts do not average out. Such
// gains are found for the scouts of ImageParts and around the best of the thinned candidates.
//
// Supposing a candidate measured changes P by a matrix of rank one, and all scores with it in a few
// operations each: so a batch can be chosen one by one without measuring in between.
class ProcessGain {
 public:
  ProcessGain(std::vector<Candidate> candidates, const ProcessGainOptions& options);
  ProcessGain(const ProcessGain&) = delete;
  ProcessGain& operator=(const ProcessGain&) = delete;

  const std::vector<Candidate>& candidates() const { return candidates_; }

  // The state of knowledge: after every fit. The features of all candidates are evaluated when the
  // model is another one than before.
  void Learn(std::shared_ptr<const ProcessModel> model, const ProcessPosterior& posterior,
             const ProcessOptions& process);
  // As if this candidate had been measured, so many exposures averaged.
  void Suppose(int candidate, int frames = 1);

  // What a candidate with that gain is worth. Called often.
  using Worth = std::function<double(const Candidate&, double gain)>;
  struct Choice {
    int candidate = -1;  // -1: none is left
    double gain = 0;     // share of the expected error, were it to fall on like that (0 .. 1)
    double score = 0;    // its worth
  };
  // The candidate that is worth most among those not `spent`.
  Choice Best(const std::vector<bool>& spent, const Worth& worth) const;
  // The gain of one candidate, or of each of several.
  double GainOf(int candidate, int frames = 1) const { return GainsOf({candidate}, frames)[0]; }
  std::vector<double> GainsOf(const std::vector<int>& candidates, int frames = 1) const;

  // Mean absolute error of the objective's quantity that the fit as it is will hardly exceed
  // (ProcessPrior::error_margin), and what would be left of it if every weight were known.
  double predicted_error() const { return predicted_error_; }
  double floor_error() const { return floor_error_; }

 private:
  // One group of series, as far as scoring needs it.
  struct GroupState {
    Eigen::MatrixXd covariance;  // P
    Eigen::MatrixXd objective;   // A, summed over the series of the group
    Eigen::MatrixXd taught;      // P A P
    Eigen::VectorXf variance;    // phi' P phi of the coarse candidates
    Eigen::VectorXf numerator;   // phi' P A P phi of them
    Eigen::VectorXf noise;       // r of them
  };

  void SetModel(std::shared_ptr<const ProcessModel> model);
  void SetObjective(const ProcessPosterior& posterior, const ProcessOptions& process);
  void ScoreCoarse();
  // r of a reading of so many frames, for every group.
  std::vector<double> NoiseVariance(int candidate, int frames) const;
  Rgb Noise(const DirectionPair& pair, const Rgb& f_r) const;
  std::vector<int> Near(int candidate) const;
  // The gain of all parts of an image together, not yet as a share.
  double ImageGain(const std::vector<int>& parts, int frames) const;
  void SupposeOne(int candidate, int frames);

  std::vector<Candidate> candidates_;
  ProcessGainOptions options_;
  std::vector<SpreadDirection> targets_;
  std::vector<int> coarse_;
  ImageParts parts_;
  std::vector<std::vector<int>> cells_;  // candidates of each raster cell
  int rows_ = 0;
  int columns_ = 0;

  std::shared_ptr<const ProcessModel> model_;
  std::vector<Eigen::MatrixXf> features_;   // per group: a column for each candidate
  std::vector<Eigen::MatrixXf> on_coarse_;  // the coarse ones of them, side by side
  std::vector<Eigen::MatrixXf> on_targets_;
  Eigen::MatrixXd candidate_means_;  // 3 series, a column for each candidate
  Eigen::MatrixXd target_means_;
  std::array<Eigen::VectorXf, kChannels> weights_;
  double model_error_ = 0;
  double repeatability_ = 0;

  std::vector<GroupState> groups_;
  double total_ = 0;  // the objective's variance now
  double predicted_error_ = 0;
  double floor_error_ = 0;
};

}  // namespace gonio
