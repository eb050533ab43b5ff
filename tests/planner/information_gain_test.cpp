// SPDX-License-Identifier: Apache-2.0
#include "planner/information_gain.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "core/units.h"
#include "fitting/generalised_log.h"
#include "tests/fitting/synthetic.h"

namespace gonio {
namespace {

constexpr DsbrdfShape kSmall{.lobes = 2, .knots = 5};

std::vector<Candidate> FewCandidates() {
  return MakeCandidates({.theta_h_count = 6, .theta_d_count = 5}, {});
}

const DsbrdfFit& SmallFit() {
  static const DsbrdfFit fit =
      FitDsbrdf(Readings(SyntheticMaterial(1, kSmall), 15, 0.02, 1), GenericPrior(kSmall));
  return fit;
}

// The Jacobian of f_r by finite differences of the whole model: a row for each channel.
Eigen::MatrixXd Jacobian(const Dsbrdf& model, const HalfDiff& angles) {
  constexpr double kStep = 1e-5;
  const HalfDiff across{angles.theta_h, angles.theta_d, kPi / 2};
  const Eigen::VectorXd& p = model.parameters();
  Eigen::MatrixXd jacobian(kChannels, p.size());
  for (Eigen::Index i = 0; i < p.size(); ++i) {
    const Eigen::VectorXd step = kStep * Eigen::VectorXd::Unit(p.size(), i);
    jacobian.col(i) = (*Dsbrdf(model.shape(), p + step).Eval(across) -
                       *Dsbrdf(model.shape(), p - step).Eval(across)) /
                      (2 * kStep);
  }
  return jacobian;
}

// What candidate `x` stands for: its share of all phi_d that count, and the mean cos theta_i there.
void PhiAverage(const HalfDiff& angles, double max_polar, double* share, double* cosine) {
  *share = *cosine = 0;
  for (int p = 0; p < 60; ++p) {
    const DirectionPair pair = ToDirections({angles.theta_h, angles.theta_d, (p + 0.5) * kPi / 60});
    const double limit = std::cos(max_polar);
    if (pair.cos_theta_i() < limit || pair.cos_theta_o() < limit) continue;
    *share += 1.0 / 60;
    *cosine += pair.cos_theta_i() / 60;
  }
  if (*share > 0) *cosine /= *share;
}

// The definitions in planner/information_gain.h with full matrices.
struct BruteForce {
  BruteForce(const DsbrdfFit& fit, const std::vector<Candidate>& candidates,
             const GainOptions& options, const std::vector<int>& measured)
      : fit_(fit), candidates_(candidates), options_(options), measured_(measured) {
    const Eigen::Index size = fit.covariance().rows();
    objective = Eigen::MatrixXd::Zero(size, size);
    double total = 0;
    for (const Candidate& candidate : candidates) {
      double share = 0;
      double cosine = 0;
      PhiAverage(candidate.angles, options.max_polar, &share, &cosine);
      total += share * candidate.cell_area;
    }
    for (const Candidate& candidate : candidates) {
      double share = 0;
      double cosine = 0;
      PhiAverage(candidate.angles, options.max_polar, &share, &cosine);
      const double weight = share * candidate.cell_area / total / kChannels;
      const Eigen::MatrixXd jacobian = Jacobian(fit.model(), candidate.angles);
      const Prediction at = fit.Predict(candidate.angles);
      for (int c = 0; c < kChannels; ++c) {
        const double f = at.f_r[c];
        const double slope = options.objective == Objective::kMale
                                 ? cosine / (1 + f * cosine)
                                 : 1 / std::hypot(f, 2 * fit.summary().floor);
        objective += weight * slope * slope * jacobian.row(c).transpose() * jacobian.row(c);
        predicted_error += weight * std::sqrt(2 / kPi) * slope * at.sigma[c];
      }
    }
    before = (objective * fit.covariance()).trace();
  }

  // The share of trace(A P) that a Kalman update with these candidates, seen in one image, takes
  // away.
  double Gain(const std::vector<int>& parts) const {
    const Eigen::MatrixXd& p = fit_.covariance();
    const double me = fit_.summary().model_error;
    const Eigen::Index rows = kChannels * std::ssize(parts);
    Eigen::MatrixXd j(rows, p.cols());
    Eigen::VectorXd draw(rows);  // of one unit of the image's common noise
    Eigen::MatrixXd noise = Eigen::MatrixXd::Zero(rows, rows);
    for (Eigen::Index k = 0; k < rows; ++k) {
      const HalfDiff& at = candidates_[parts[k / kChannels]].angles;
      const int c = static_cast<int>(k % kChannels);
      const Rgb f = *fit_.Eval(HalfDiff{at.theta_h, at.theta_d, kPi / 2});
      const double slope = GeneralisedLogSlope(f[c], fit_.summary().floor);
      j.row(k) = slope * Jacobian(fit_.model(), at).row(c);
      draw[k] = options_.relative_noise * f[c] * slope;
      noise(k, k) = me * me * Crowding(at) + 1e-8;
    }
    for (Eigen::Index k = 0; k < rows; ++k) {
      for (Eigen::Index l = 0; l < rows; ++l) {
        if (k % kChannels == l % kChannels) noise(k, l) += draw[k] * draw[l];
      }
    }
    const Eigen::MatrixXd spread = j * p * j.transpose() + noise;
    const Eigen::MatrixXd updated = p - p * j.transpose() * spread.inverse() * j * p;
    return 1 - (objective * updated).trace() / before;
  }
  double Crowding(const HalfDiff& a) const {
    double crowding = 1;
    for (const int m : measured_) {
      const HalfDiff& b = candidates_[m].angles;
      const double dh = std::sqrt(a.theta_h / (kPi / 2)) - std::sqrt(b.theta_h / (kPi / 2));
      const double dd = (a.theta_d - b.theta_d) / (kPi / 2);
      crowding += std::exp(-(dh * dh + dd * dd) / (2 * std::pow(options_.repeat_length, 2)));
    }
    return crowding;
  }

  const DsbrdfFit& fit_;
  const std::vector<Candidate>& candidates_;
  const GainOptions& options_;
  const std::vector<int>& measured_;
  Eigen::MatrixXd objective;
  double before = 0;
  double predicted_error = 0;
};

TEST(InformationGain, IsTheDropOfTheObjectiveThatFullMatricesShow) {
  const std::vector<Candidate> candidates = FewCandidates();
  for (const Objective objective : {Objective::kMale, Objective::kRelative}) {
    for (const std::vector<int>& measured : {std::vector<int>{}, {3, 7, 7, 20}}) {
      const GainOptions options{.objective = objective, .repeat_length = 0.2};
      const GainScores scores = InformationGain(candidates, options).Evaluate(SmallFit(), measured);
      const BruteForce brute(SmallFit(), candidates, options, measured);
      ASSERT_EQ(scores.gain.size(), static_cast<Eigen::Index>(candidates.size()));
      for (std::size_t i = 0; i < candidates.size(); ++i) {
        EXPECT_NEAR(scores.gain[static_cast<Eigen::Index>(i)], brute.Gain({static_cast<int>(i)}),
                    1e-6);
      }
      EXPECT_NEAR(scores.predicted_error, brute.predicted_error, 1e-5 * brute.predicted_error);
    }
  }
}

// A part for each of these candidates beside the pose itself.
PartsOf Along(const std::vector<Candidate>& candidates, const std::vector<int>& parts) {
  return [&candidates, parts](const DirectionPair& pair) {
    std::vector<DirectionPair> all = {pair};
    for (const int i : parts) all.push_back(candidates[i].directions);
    return all;
  };
}

TEST(InformationGain, OfAnImageWithOneSampleIsThatOfTheSample) {
  const std::vector<Candidate> candidates = FewCandidates();
  const GainScores alone = InformationGain(candidates, {}).Evaluate(SmallFit(), {3, 7});
  const GainScores image =
      InformationGain(candidates, {.parts = Along(candidates, {})}).Evaluate(SmallFit(), {3, 7});
  EXPECT_LT((image.gain - alone.gain).cwiseAbs().maxCoeff(), 1e-9);
}

// Example failure is parts that are counted as if each were measured on another day.
TEST(InformationGain, OfAnImageIsWhatFullMatricesShow) {
  const std::vector<Candidate> candidates = FewCandidates();
  const std::vector<int> parts = {2, 9, 17};
  const GainOptions options{.relative_noise = 0.1, .parts = Along(candidates, parts)};
  const GainScores image = InformationGain(candidates, options).Evaluate(SmallFit(), {3, 7});
  const std::vector<int> measured = {3, 7};
  const BruteForce brute(SmallFit(), candidates, options, measured);
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    std::vector<int> all = {static_cast<int>(i)};
    for (const int part : parts) {
      if (part != all.front()) all.push_back(part);
    }
    EXPECT_NEAR(image.gain[static_cast<Eigen::Index>(i)], brute.Gain(all), 1e-6) << i;
  }
}

TEST(InformationGain, LiesBetweenZeroAndOne) {
  const std::vector<Candidate> candidates = MakeCandidates({}, {});
  const DsbrdfFit fit = FitDsbrdf(Readings(SyntheticMaterial(2), 12, 0.02, 2), GenericPrior());
  for (const Objective objective : {Objective::kMale, Objective::kRelative}) {
    const GainScores scores =
        InformationGain(candidates, {.objective = objective}).Evaluate(fit, {0, 100});
    EXPECT_TRUE(scores.gain.allFinite());
    EXPECT_GE(scores.gain.minCoeff(), 0);
    EXPECT_LE(scores.gain.maxCoeff(), 1);
    EXPECT_GT(scores.gain.maxCoeff(), 0.01);
    EXPECT_GT(scores.predicted_error, 0);
  }
}

TEST(InformationGain, PaysLessWhereSomethingWasMeasuredNearby) {
  const std::vector<Candidate> candidates = MakeCandidates({}, {});
  const DsbrdfFit fit = FitDsbrdf(Readings(SyntheticMaterial(3), 12, 0.02, 3), GenericPrior());
  const InformationGain gain(candidates, {});
  const Eigen::VectorXd fresh = gain.Evaluate(fit, {}).gain;
  constexpr int kMeasured = 30 * 90 + 40;
  const Eigen::VectorXd after = gain.Evaluate(fit, {kMeasured}).gain;
  const Eigen::VectorXd twice = gain.Evaluate(fit, {kMeasured, kMeasured}).gain;
  EXPECT_LT(after[kMeasured], fresh[kMeasured]);
  EXPECT_LT(twice[kMeasured], after[kMeasured]);
  EXPECT_LT(after[kMeasured + 1], fresh[kMeasured + 1]);
  EXPECT_GT(after[kMeasured + 1] / fresh[kMeasured + 1], after[kMeasured] / fresh[kMeasured]);
  EXPECT_EQ(after[80 * 90 + 5], fresh[80 * 90 + 5]);
}

TEST(InformationGain, PredictsASmallerErrorForASmallerCovariance) {
  const InformationGain gain(FewCandidates(), {});
  double last = gain.Evaluate(SmallFit(), {}).predicted_error;
  for (const double shrunk : {0.5, 0.1, 0.01}) {
    const DsbrdfFit fit(SmallFit().model(), shrunk * SmallFit().covariance(), SmallFit().summary());
    const double error = gain.Evaluate(fit, {}).predicted_error;
    EXPECT_LT(error, last);
    last = error;
  }
  // What is left is the model error.
  EXPECT_GT(last, 0);
}

TEST(InformationGain, CountsOnlyDirectionsWithinMaxPolar) {
  const std::vector<Candidate> candidates = MakeCandidates({}, {});
  const DsbrdfFit fit = FitDsbrdf(Readings(SyntheticMaterial(4), 30, 0.02, 4), GenericPrior());
  const GainScores all = InformationGain(candidates, {}).Evaluate(fit, {});
  const GainScores steep =
      InformationGain(candidates, {.max_polar = RadFromDeg(20)}).Evaluate(fit, {});
  EXPECT_NE(all.predicted_error, steep.predicted_error);
  // A grazing pose (theta_d = 85 deg) tells little about directions near the normal.
  const int grazing = NearestCandidate(candidates, RadFromDeg(3), RadFromDeg(85));
  EXPECT_LT(steep.gain[grazing] / steep.gain.maxCoeff(),
            0.5 * all.gain[grazing] / all.gain.maxCoeff());
}

TEST(InformationGain, PromisesNothingWhereNoDirectionCounts) {
  const std::vector<Candidate> candidates = MakeCandidates(
      {.theta_h_count = 10, .theta_d_count = 10},
      [](const DirectionPair& pair) { return ToHalfDiff(pair).theta_d > RadFromDeg(50); });
  const GainScores scores =
      InformationGain(candidates, {.max_polar = RadFromDeg(30)}).Evaluate(SmallFit(), {});
  EXPECT_EQ(scores.gain.cwiseAbs().maxCoeff(), 0);
  EXPECT_EQ(scores.predicted_error, 0);
}

TEST(InformationGain, DoesNotMindTheOrderOfCandidates) {
  std::vector<Candidate> candidates = FewCandidates();
  const GainScores forwards = InformationGain(candidates, {}).Evaluate(SmallFit(), {});
  std::reverse(candidates.begin(), candidates.end());
  const GainScores backwards = InformationGain(candidates, {}).Evaluate(SmallFit(), {});
  EXPECT_LT((forwards.gain - backwards.gain.reverse()).cwiseAbs().maxCoeff(), 1e-9);
  EXPECT_NEAR(forwards.predicted_error, backwards.predicted_error, 1e-12);
}

TEST(NearestCandidate, IsTheNearestOnTheUnitSquare) {
  const std::vector<Candidate> candidates = MakeCandidates({}, {});
  for (const int i : {0, 89, 4321, 8099}) {
    EXPECT_EQ(
        NearestCandidate(candidates, candidates[i].angles.theta_h, candidates[i].angles.theta_d),
        i);
  }
  EXPECT_EQ(NearestCandidate(candidates, kPi / 2, 0), 89 * 90);
  EXPECT_EQ(NearestCandidate({}, 0.1, 0.1), -1);
}

}  // namespace
}  // namespace gonio
