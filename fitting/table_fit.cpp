// SPDX-License-Identifier: Apache-2.0
#include "fitting/table_fit.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "brdf/samples_csv.h"
#include "core/error.h"
#include "fitting/hemi_epd.h"
#include "fitting/slice_em.h"
#include "fitting/slice_fit.h"
#include "fitting/slice_joint.h"

namespace gonio {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

std::string At(double theta_d, const std::string& what) {
  return fmt::format("theta_d {:.1f} deg: {}", DegFromRad(theta_d), what);
}

// The slices of one channel that can be fitted, and complaints about those that cannot.
struct Sorted {
  std::vector<double> theta_d;
  std::vector<std::vector<SlicePoint>> points;
  std::vector<SliceReport> unfittable;
};

Sorted SortOut(std::span<const SliceData> slices, int channel, int lobes) {
  Sorted sorted;
  for (const SliceData& slice : slices) {
    const std::vector<SlicePoint>& points = slice.points[channel];
    if (const auto complaint = WhyNotFittable(points, lobes)) {
      sorted.unfittable.push_back({.theta_d = slice.theta_d,
                                   .channel = channel,
                                   .points = static_cast<int>(points.size()),
                                   .reason = *complaint});
    } else {
      sorted.theta_d.push_back(slice.theta_d);
      sorted.points.push_back(points);
    }
  }
  return sorted;
}

std::string Complaint(const Sorted& sorted) {
  if (sorted.unfittable.empty()) return "no slice holds a reading";
  const SliceReport& first = sorted.unfittable.front();
  std::string text = At(first.theta_d, first.reason);
  if (const std::size_t others = sorted.unfittable.size() - 1; others > 0) {
    text += fmt::format("; likewise {} more of {} slices", others,
                        sorted.unfittable.size() + sorted.theta_d.size());
  }
  return text;
}

std::vector<SliceFit> FitEach(const Sorted& sorted, FitMethod method, int lobes) {
  if (method == FitMethod::kJoint) return FitSlicesJoint(sorted.points, {.lobes = lobes});
  std::vector<SliceFit> fits;
  for (const auto& points : sorted.points) fits.push_back(FitSliceEm(points, {.lobes = lobes}));
  return fits;
}

class SlicedFit {
 public:
  SlicedFit(std::span<const SliceData> slices, const TableFitOptions& options)
      : slices_(slices), options_(options) {}

  TableFit Run() {
    for (int c = 0; c < kChannels; ++c) {
      if (options_.channels[c]) FitChannel(c);
    }
    if (std::all_of(fitted_.begin(), fitted_.end(), [](const auto& f) { return f.empty(); })) {
      return std::move(fit_);
    }
    const SliceMethod method =
        options_.method == FitMethod::kEm ? SliceMethod::kEm : SliceMethod::kJoint;
    auto model = std::make_unique<SlicedDsbrdf>(method, std::move(fitted_), std::move(reports_));
    fit_.parameters = model->parameter_count();
    fit_.model = std::move(model);
    return std::move(fit_);
  }

 private:
  void FitChannel(int channel) {
    const Sorted sorted = SortOut(slices_, channel, options_.lobes);
    reports_.insert(reports_.end(), sorted.unfittable.begin(), sorted.unfittable.end());
    if (sorted.points.empty() || sorted.points.size() < sorted.unfittable.size()) {
      fit_.failures.push_back({channel, Complaint(sorted)});
      return;
    }
    if (!sorted.unfittable.empty()) fit_.warnings.push_back({channel, Complaint(sorted)});
    const std::vector<SliceFit> fits = FitEach(sorted, options_.method, options_.lobes);
    for (std::size_t i = 0; i < fits.size(); ++i) {
      fitted_[channel].push_back({sorted.theta_d[i], fits[i].lobes});
      Report(channel, sorted.theta_d[i], sorted.points[i], fits[i]);
    }
    WarnOfConstants(channel, sorted);
  }

  void Report(int channel, double theta_d, std::span<const SlicePoint> points,
              const SliceFit& fit) {
    const auto valid = std::count_if(points.begin(), points.end(),
                                     [](const SlicePoint& point) { return point.cells > 0; });
    reports_.push_back({.theta_d = theta_d,
                        .channel = channel,
                        .points = static_cast<int>(valid),
                        .iterations = fit.iterations,
                        .converged = fit.converged,
                        .cost = fit.cost,
                        .reason = fit.reason});
    if (!fit.converged) ++fit_.unconverged;
  }

  void WarnOfConstants(int channel, const Sorted& sorted) {
    const auto constant = [](const auto& points) { return IsConstant(points); };
    const auto first = std::find_if(sorted.points.begin(), sorted.points.end(), constant);
    if (first == sorted.points.end() || options_.lobes == 1) return;
    fit_.warnings.push_back(
        {channel, At(sorted.theta_d[first - sorted.points.begin()],
                     "every reading is the same, so that lobes beyond the first mean nothing")});
  }

  std::span<const SliceData> slices_;
  const TableFitOptions& options_;
  TableFit fit_;
  std::array<std::vector<FittedSlice>, kChannels> fitted_;
  std::vector<SliceReport> reports_;
};

// Channels that hold too little for the lobes; the others' indices stay in `channels`.
std::vector<ChannelFailure> TooLittle(std::span<const BrdfSample> samples, int lobes,
                                      const std::array<bool, kChannels>& channels) {
  std::vector<ChannelFailure> failures;
  for (int c = 0; c < kChannels; ++c) {
    if (!channels[c]) continue;
    const auto valid = std::count_if(samples.begin(), samples.end(), [&](const BrdfSample& s) {
      return std::isfinite(s.sigma[c]);
    });
    if (valid == 0) {
      failures.push_back({c, "no reading is valid"});
    } else if (valid < 2 * lobes) {
      failures.push_back({c, fmt::format("{} valid readings for the {} parameters of {} lobes at a "
                                         "single theta_d",
                                         valid, 2 * lobes, lobes)});
    }
  }
  return failures;
}

TableFit FitContinuous(std::vector<BrdfSample> samples, const TableFitOptions& options) {
  const Prior prior = options.prior != nullptr
                          ? *options.prior
                          : GenericPrior({.lobes = options.lobes, .knots = options.knots});
  std::array<bool, kChannels> channels = options.channels;
  TableFit fit;
  fit.failures = TooLittle(samples, prior.shape.lobes, channels);
  for (const ChannelFailure& failure : fit.failures) channels[failure.channel] = false;
  if (std::none_of(channels.begin(), channels.end(), [](bool fitted) { return fitted; })) {
    return fit;
  }
  for (BrdfSample& sample : samples) {
    for (int c = 0; c < kChannels; ++c) {
      if (!channels[c]) sample.sigma[c] = kInfinity;
    }
  }
  auto model = std::make_unique<DsbrdfFit>(FitDsbrdf(samples, prior, options.continuous));
  fit.parameters = prior.shape.per_channel() *
                   static_cast<int>(std::count(channels.begin(), channels.end(), true));
  fit.unconverged = model->summary().converged ? 0 : 1;
  fit.model = std::move(model);
  return fit;
}

void CheckLobes(const TableFitOptions& options) {
  CheckShape({.lobes = options.lobes});
  if (options.prior != nullptr && options.method == FitMethod::kContinuous &&
      options.prior->shape.lobes != options.lobes) {
    throw ConfigError(fmt::format("{}: is a prior for {} lobes, not {}", options.prior->name,
                                  options.prior->shape.lobes, options.lobes));
  }
}

// One slice for each row of cells: the continuous fit needs no rests between slices.
SliceOptions EveryThetaD(SliceOptions options) {
  options.step = RadFromDeg(1);
  return options;
}

}  // namespace

std::string_view NameOf(FitMethod method) {
  switch (method) {
    case FitMethod::kEm:
      return "em";
    case FitMethod::kJoint:
      return "joint";
    case FitMethod::kContinuous:
      return "continuous";
  }
  return "?";
}

FitMethod FitMethodFromName(std::string_view name) {
  for (const FitMethod method : {FitMethod::kEm, FitMethod::kJoint, FitMethod::kContinuous}) {
    if (name == NameOf(method)) return method;
  }
  throw ConfigError(fmt::format("method: is \"{}\", must be one of em, joint, continuous", name));
}

TableFit FitTable(const Brdf& brdf, const TableFitOptions& options) {
  CheckLobes(options);
  if (options.method == FitMethod::kContinuous) {
    return FitContinuous(SamplesOf(SlicesOf(brdf, EveryThetaD(options.slices)), options.channels),
                         options);
  }
  return SlicedFit(SlicesOf(brdf, options.slices), options).Run();
}

TableFit FitSamples(std::span<const BrdfSample> samples, const TableFitOptions& options) {
  CheckLobes(options);
  if (options.method == FitMethod::kContinuous) {
    return FitContinuous({samples.begin(), samples.end()}, options);
  }
  return SlicedFit(SlicesOf(samples, options.slices), options).Run();
}

std::vector<BrdfSample> SamplesOf(std::span<const SliceData> slices,
                                  const std::array<bool, kChannels>& channels) {
  std::vector<BrdfSample> samples;
  for (const SliceData& slice : slices) {
    for (std::size_t i = 0; i < slice.points[0].size(); ++i) {
      BrdfSample sample;
      sample.directions = ToDirections({slice.points[0][i].theta_h, slice.theta_d, kPi / 2});
      for (int c = 0; c < kChannels; ++c) {
        const SlicePoint& point = slice.points[c][i];
        sample.f_r[c] = point.f_r;
        sample.sigma[c] = point.cells > 0 && channels[c]
                              ? kDefaultRelativeSigma * std::abs(point.f_r) + kDefaultSigmaFloor
                              : kInfinity;
      }
      if (sample.sigma.isFinite().any() && sample.directions.above_horizon()) {
        samples.push_back(sample);
      }
    }
  }
  return samples;
}

double Bic(const LobeModel& model, int parameters, std::span<const SliceData> slices) {
  double sum = 0;
  double n = 0;
  for (const SliceData& slice : slices) {
    for (int c = 0; c < kChannels; ++c) {
      const std::vector<Lobe> lobes = model.LobesAt(slice.theta_d, c);
      if (lobes.empty()) continue;
      for (const SlicePoint& point : slice.points[c]) {
        if (point.cells == 0) continue;
        double f_r = 0;
        for (const Lobe& lobe : lobes) f_r += EvalLobe(lobe, LogCos(point.theta_h));
        const double r = std::log1p(std::max(point.cos_theta_i * point.f_r, -0.9)) -
                         std::log1p(point.cos_theta_i * f_r);
        sum += r * r;
        ++n;
      }
    }
  }
  return n * std::log(std::max(sum / n, 1e-300)) + parameters * std::log(n);
}

TableFit FitTableChoosingLobes(const Brdf& brdf, TableFitOptions options) {
  if (options.prior != nullptr) {
    throw ConfigError(options.prior->name + ": a prior fixes the number of lobes");
  }
  const std::vector<SliceData> slices = SlicesOf(brdf, options.slices);
  TableFit best;
  double best_bic = kInfinity;
  for (options.lobes = 1; options.lobes <= kMaxLobes; ++options.lobes) {
    TableFit fit = FitTable(brdf, options);
    const double bic = fit.model ? Bic(*fit.model, fit.parameters, slices) : kInfinity;
    if (bic < best_bic || options.lobes == 1) {
      best_bic = bic;
      best = std::move(fit);
    }
  }
  return best;
}

}  // namespace gonio
