// SPDX-License-Identifier: Apache-2.0
#include "fitting/lobe_learning.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <vector>

#include "core/task_pool.h"
#include "core/units.h"
#include "fitting/fit.h"

namespace gonio {
namespace {

constexpr double kRelativeSigma = 0.01;
constexpr double kAbsoluteSigma = 1e-4;  // 1/sr
// What may be tried: how many materials the generic prior is worth.
constexpr double kGenericWeights[] = {2, 4, 8, 16, 32, 64};
const double kMostPolar = std::cos(RadFromDeg(80));

// A material's parameters and what its samples leave open of them.
struct Fitted {
  Eigen::VectorXd mean;
  Eigen::MatrixXd covariance;
};

std::vector<BrdfSample> ReadMaterial(const Brdf& material, const LobeLearningOptions& options) {
  std::vector<BrdfSample> samples;
  for (int h = 0; h < options.theta_h; ++h) {
    const double u = (h + 0.5) / options.theta_h;
    for (int d = 0; d < options.theta_d; ++d) {
      // A DSBRDF does not see phi_d: neighbours differ in it, so that a fit averages over it.
      const double phi_d = ((7 * h + 5 * d) % 12 + 0.5) / 12 * kPi;
      const HalfDiff angles{u * u * kPi / 2, (d + 0.5) / options.theta_d * kPi / 2, phi_d};
      double cos_i = 0;
      double cos_o = 0;
      Cosines(angles, &cos_i, &cos_o);
      if (std::min(cos_i, cos_o) < kMostPolar) continue;
      const std::optional<Rgb> f_r = material.Eval(angles);
      if (!f_r) continue;
      samples.push_back(
          {ToDirections(angles), *f_r,
           ((kRelativeSigma * *f_r).square() + kAbsoluteSigma * kAbsoluteSigma).sqrt()});
    }
  }
  return samples;
}

// Where each parameter goes when lobe k takes the place order[k].
std::vector<int> Places(const DsbrdfShape& shape, const std::vector<int>& order) {
  std::vector<int> places(shape.size());
  for (int c = 0; c < kChannels; ++c) {
    for (int k = 0; k < shape.lobes; ++k) {
      for (int q = 0; q < 2; ++q) {
        for (int n = 0; n < shape.knots; ++n) {
          places[shape.Index(c, k, q) + n] = shape.Index(c, order[k], q) + n;
        }
      }
    }
  }
  return places;
}

Fitted Moved(const Fitted& fitted, const std::vector<int>& places) {
  Fitted moved = fitted;
  const auto size = static_cast<Eigen::Index>(places.size());
  for (Eigen::Index i = 0; i < size; ++i) {
    moved.mean[places[i]] = fitted.mean[i];
    for (Eigen::Index j = 0; j < size; ++j) {
      moved.covariance(places[i], places[j]) = fitted.covariance(i, j);
    }
  }
  return moved;
}

// With its lobes in the order that is nearest to the prior's mean, in its standard deviations.
Fitted Aligned(const Fitted& fitted, const Prior& prior) {
  std::vector<int> order(prior.shape.lobes);
  std::iota(order.begin(), order.end(), 0);
  const Eigen::ArrayXd sd = prior.covariance.diagonal().array().sqrt();
  double nearest = std::numeric_limits<double>::infinity();
  Fitted best = fitted;
  do {
    Fitted moved = Moved(fitted, Places(prior.shape, order));
    const double distance = ((moved.mean - prior.mean).array() / sd).square().sum();
    if (distance >= nearest) continue;
    nearest = distance;
    best = std::move(moved);
  } while (std::next_permutation(order.begin(), order.end()));
  return best;
}

// What some of the materials have in common, the generic prior being worth so many more.
Prior Common(const std::vector<Fitted>& all, const Prior& generic, double weight, int left_out) {
  Prior prior = generic;
  double count = 1;  // of the mean the generic prior is worth one material
  for (int m = 0; m < std::ssize(all); ++m) {
    if (m == left_out) continue;
    prior.mean += all[m].mean;
    ++count;
  }
  prior.mean /= count;
  prior.covariance *= weight;
  for (int m = 0; m < std::ssize(all); ++m) {
    if (m == left_out) continue;
    const Eigen::VectorXd off = all[m].mean - prior.mean;
    prior.covariance += off * off.transpose() + all[m].covariance;
  }
  prior.covariance /= count - 1 + weight;
  return prior;
}

// Log likelihood of each material under what the others have in common, but for a constant.
double Foretold(const std::vector<Fitted>& all, const Prior& generic, double weight) {
  double sum = 0;
  for (int m = 0; m < std::ssize(all); ++m) {
    const Prior others = Common(all, generic, weight, m);
    const Eigen::LLT<Eigen::MatrixXd> llt(others.covariance + all[m].covariance);
    const Eigen::VectorXd off = llt.matrixL().solve(all[m].mean - others.mean);
    sum -= 0.5 * off.squaredNorm() + llt.matrixLLT().diagonal().array().log().sum();
  }
  return sum;
}

}  // namespace

void LearnLobes(std::span<const TrainingMaterial> materials, const LobeLearningOptions& options,
                Prior* prior) {
  const Prior generic = *prior;
  std::vector<Fitted> all(materials.size());
  for (int pass = 0; pass < options.passes; ++pass) {
    ForEachTask(materials.size(), options.threads, {}, [&](std::size_t m) {
      const DsbrdfFit fit = FitDsbrdf(ReadMaterial(*materials[m].brdf, options), *prior);
      all[m] = Aligned({fit.model().parameters(), fit.covariance()}, *prior);
    });
    double best = -std::numeric_limits<double>::infinity();
    double weight = 0;
    for (const double tried : kGenericWeights) {
      const double foretold = Foretold(all, generic, tried);
      if (foretold <= best) continue;
      best = foretold;
      weight = tried;
    }
    const Prior common = Common(all, generic, weight, -1);
    prior->mean = common.mean;
    prior->covariance = 0.5 * (common.covariance + common.covariance.transpose());
  }
}

}  // namespace gonio
