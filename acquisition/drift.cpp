// SPDX-License-Identifier: Apache-2.0
#include "acquisition/drift.h"

#include <algorithm>
#include <cmath>

#include "core/check.h"
#include "core/units.h"

namespace gonio {
namespace {

constexpr double kFaint = 0.2;        // sigma over signal of a first visit that says too little
constexpr double kLeastSigma = 1e-9;  // a visit without noise would make the equations singular
constexpr double kPriorWeight = 2;    // degrees of freedom of what is thought before
// q is looked for between these powers of ten of its expectation, so many steps to each.
constexpr int kDecades = 5;
constexpr int kSteps = 20;

double HoursOf(Seconds time) { return time.count() / 3600; }

double Square(double x) { return x * x; }

}  // namespace

DriftPolicy ReadDriftPolicy(const ConfigNode& node, double phi_d_deg) {
  DriftPolicy policy;
  policy.every_poses = node.IntegerOr("every_poses", 0, 1, 1000000);
  policy.every = Seconds(60 * node.NumberOr("every_min", 0, Range::Positive()));
  if (!policy.on()) node.Fail("every_poses", "this or every_min is needed");
  if (node.Has("pose")) {
    const ConfigNode pose = node.Map("pose");
    policy.pose = HalfDiff{
        .theta_h = RadFromDeg(pose.Number("theta_h_deg", Range::Between(0, 90))),
        .theta_d = RadFromDeg(pose.Number("theta_d_deg", Range::Between(0, 90))),
        .phi_d = RadFromDeg(pose.NumberOr("phi_d_deg", phi_d_deg, Range::Between(0, 180)))};
  }
  policy.frames = node.IntegerOr("frames", policy.frames, 1, 100);
  policy.expected_per_hour =
      node.NumberOr("expected_percent_per_hour", 100 * policy.expected_per_hour,
                    Range::Between(1e-4, 100)) /
      100;
  if (node.Has("max_change_percent")) {
    policy.max_change = node.Number("max_change_percent", Range::Positive()) / 100;
  }
  policy.stop =
      node.Has("when_exceeded") && node.Choice("when_exceeded", {"warn", "stop"}) == "stop";
  return policy;
}

DriftTracker::DriftTracker(double expected_per_hour)
    : expected_(Square(expected_per_hour)), diffusion_(expected_) {
  GONIO_CHECK(expected_per_hour > 0, "a drift that is known to be none");
}

void DriftTracker::Add(const ReferenceVisit& visit) {
  ++visits_;
  const double now = HoursOf(visit.time);
  for (int c = 0; c < kChannels; ++c) {
    Channel& channel = channels_[static_cast<std::size_t>(c)];
    if (!std::isfinite(visit.sigma[c]) || !std::isfinite(visit.signal[c])) continue;
    if (channel.hours.empty()) {
      if (!(visit.sigma[c] < kFaint * visit.signal[c])) continue;
      channel.scale = visit.signal[c];
    }
    GONIO_CHECK(channel.hours.empty() || now > channel.hours.back(), "visits in order of time");
    channel.hours.push_back(now);
    channel.y.push_back(visit.signal[c] / channel.scale);
    channel.sigma.push_back(std::max(visit.sigma[c] / channel.scale, kLeastSigma));
  }
  double best = LogPosterior(expected_);
  diffusion_ = expected_;
  for (int i = -kDecades * kSteps; i <= kDecades * kSteps; ++i) {
    const double q = expected_ * std::pow(10.0, static_cast<double>(i) / kSteps);
    const double here = LogPosterior(q);
    if (!(here > best)) continue;
    best = here;
    diffusion_ = q;
  }
  for (Channel& channel : channels_) {
    std::vector<double> right;
    for (std::size_t k = 0; k < channel.y.size(); ++k) {
      right.push_back(channel.y[k] / Square(channel.sigma[k]));
    }
    channel.smooth = Solve(channel, std::move(right));
  }
}

// By the innovations of a Kalman filter that knows nothing before the first visit.
double DriftTracker::LogPosterior(double diffusion) const {
  double log = -kPriorWeight / 2 * (std::log(diffusion) + expected_ / diffusion);
  for (const Channel& channel : channels_) {
    if (channel.y.empty()) continue;
    double level = channel.y[0];
    double variance = Square(channel.sigma[0]);
    for (std::size_t k = 1; k < channel.y.size(); ++k) {
      variance += diffusion * (channel.hours[k] - channel.hours[k - 1]);
      const double expected = variance + Square(channel.sigma[k]);
      const double surprise = channel.y[k] - level;
      log -= 0.5 * (std::log(expected) + Square(surprise) / expected);
      level += variance / expected * surprise;
      variance *= Square(channel.sigma[k]) / expected;
    }
  }
  return log;
}

std::vector<double> DriftTracker::Solve(const Channel& channel, std::vector<double> right) const {
  const std::size_t n = right.size();
  // Precision of a step from visit k to the next.
  const auto step = [&](std::size_t k) {
    return 1 / (diffusion_ * (channel.hours[k + 1] - channel.hours[k]));
  };
  std::vector<double> diagonal(n);
  for (std::size_t k = 0; k < n; ++k) {
    diagonal[k] = 1 / Square(channel.sigma[k]);
    if (k > 0) diagonal[k] += step(k - 1);
    if (k + 1 < n) diagonal[k] += step(k);
  }
  for (std::size_t k = 1; k < n; ++k) {
    const double ratio = step(k - 1) / diagonal[k - 1];
    diagonal[k] -= ratio * step(k - 1);
    right[k] += ratio * right[k - 1];
  }
  for (std::size_t k = n; k-- > 0;) {
    if (k + 1 < n) right[k] += step(k) * right[k + 1];
    right[k] /= diagonal[k];
  }
  return right;
}

Gain DriftTracker::At(Seconds time) const {
  Gain gain;
  const double now = HoursOf(time);
  for (int c = 0; c < kChannels; ++c) {
    const Channel& channel = channels_[static_cast<std::size_t>(c)];
    const std::vector<double>& t = channel.hours;
    if (t.empty()) continue;
    const auto after =
        static_cast<std::size_t>(std::upper_bound(t.begin(), t.end(), now) - t.begin());
    // u(now) - u(t_1) is this combination of the visits' u, and the walk between.
    std::vector<double> weights(t.size(), 0.0);
    double walk = 0;
    if (after == 0) {
      weights[0] = 1;
      walk = diffusion_ * (t.front() - now);
    } else if (after == t.size()) {
      weights.back() = 1;
      walk = diffusion_ * (now - t.back());
    } else {
      const double span = t[after] - t[after - 1];
      weights[after] = (now - t[after - 1]) / span;
      weights[after - 1] = 1 - weights[after];
      walk = diffusion_ * span * weights[after] * weights[after - 1];
    }
    weights[0] -= 1;
    const std::vector<double> covariance = Solve(channel, weights);
    double change = 0;
    double variance = walk;
    for (std::size_t k = 0; k < t.size(); ++k) {
      change += weights[k] * channel.smooth[k];
      variance += weights[k] * covariance[k];
    }
    gain.value[c] = 1 + change / channel.smooth[0];
    gain.sigma[c] = std::sqrt(variance) / channel.smooth[0];
  }
  return gain;
}

}  // namespace gonio
