// SPDX-License-Identifier: Apache-2.0
#include "apps/gonio/study_summary.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>

#include "apps/gonio/statistics.h"

namespace gonio {
namespace {

using nlohmann::json;

// Names in the order in which they first appear.
template <typename Key>
std::vector<std::string> Names(const StudyResult& study, const Key& key) {
  std::vector<std::string> names;
  for (const StudyCell& cell : study.cells) {
    const std::string& name = key(cell);
    if (std::find(names.begin(), names.end(), name) == names.end()) names.push_back(name);
  }
  return names;
}

class Summary {
 public:
  Summary(const StudyResult& study, const std::string& method) {
    summary_.method = method;
    for (const StudyCell& cell : study.cells) {
      if (cell.method != method) continue;
      cells_[{cell.material, cell.keep_every}].push_back(&cell);
      summary_.keep_every.push_back(cell.keep_every);
    }
    std::vector<int>& every = summary_.keep_every;
    std::sort(every.begin(), every.end());
    every.erase(std::unique(every.begin(), every.end()), every.end());
    materials_ = Names(study, [](const StudyCell& cell) { return cell.material; });
    summary_.male = Measure("MALE", &StudyCell::male);
    summary_.mse = Measure("MSE", &StudyCell::table_mse);
  }

  MethodSummary Take() { return std::move(summary_); }

 private:
  double Error(const std::string& material, int every, double StudyCell::*metric) const {
    const auto found = cells_.find({material, every});
    if (found == cells_.end()) return StudyCell::kUnknown;
    double sum = 0;
    for (const StudyCell* cell : found->second) sum += cell->*metric;  // NaN if one failed
    return sum / static_cast<double>(found->second.size());
  }

  ThinningCurve Curve(const std::string& material, double StudyCell::*metric) const {
    ThinningCurve curve{.material = material, .error = {}};
    for (const int every : summary_.keep_every) {
      curve.error.push_back(Error(material, every, metric));
      const double ratio = curve.error.back() / curve.error.front();
      if (1.0 / every >= kHoldsDownTo) curve.worst_ratio = std::max(curve.worst_ratio, ratio);
      // Also where it could not be fitted.
      if (curve.fails_at == 0 && !(ratio <= kHoldsWithin)) curve.fails_at = every;
    }
    return curve;
  }

  MetricSummary Measure(const std::string& name, double StudyCell::*metric) const {
    MetricSummary result;
    result.metric = name;
    for (const std::string& material : materials_) {
      ThinningCurve curve = Curve(material, metric);
      if (std::isfinite(curve.error.front())) result.curves.push_back(std::move(curve));
    }
    const bool full = summary_.keep_every.front() == 1;
    for (std::size_t i = 0; i < summary_.keep_every.size(); ++i) {
      std::vector<double> errors;
      int within = 0;
      for (const ThinningCurve& curve : result.curves) {
        errors.push_back(curve.error[i]);
        within += full && curve.error[i] <= kHoldsWithin * curve.error.front();
      }
      result.median.push_back(Median(errors));
      result.mean.push_back(MeanOf(errors));
      result.within.push_back(within);
    }
    result.holds = static_cast<int>(
        std::count_if(result.curves.begin(), result.curves.end(), [&](const ThinningCurve& curve) {
          return full && (curve.fails_at == 0 || 1.0 / curve.fails_at < kHoldsDownTo);
        }));
    return result;
  }

  std::map<std::pair<std::string, int>, std::vector<const StudyCell*>> cells_;
  std::vector<std::string> materials_;
  MethodSummary summary_;
};

json Numbers(const std::vector<double>& numbers) {
  json list = json::array();
  for (const double x : numbers) list.push_back(std::isfinite(x) ? json(x) : json(nullptr));
  return list;
}

json ToJson(const MetricSummary& summary) {
  json curves = json::array();
  for (const ThinningCurve& curve : summary.curves) {
    curves.push_back({{"material", curve.material},
                      {"error", Numbers(curve.error)},
                      {"worst_ratio", curve.worst_ratio},
                      {"fails_at", curve.fails_at}});
  }
  return {{"median", Numbers(summary.median)},  {"mean", Numbers(summary.mean)},
          {"within", summary.within},           {"holds", summary.holds},
          {"materials", summary.curves.size()}, {"curves", curves}};
}

void PrintRow(const std::string& title, const std::vector<std::string>& numbers) {
  fmt::print("  {:<24}", title);
  for (const std::string& number : numbers) fmt::print("{:>11}", number);
  fmt::print("\n");
}

std::vector<std::string> Shown(const std::vector<double>& numbers) {
  std::vector<std::string> texts;
  for (const double x : numbers) texts.push_back(std::isfinite(x) ? fmt::format("{:.4g}", x) : "-");
  return texts;
}

// Who leaves the band first, at the highest density.
void PrintFirstToFail(const MethodSummary& method, const MetricSummary& metric) {
  constexpr std::size_t kShown = 5;
  std::vector<const ThinningCurve*> failing;
  for (const ThinningCurve& curve : metric.curves) {
    if (curve.fails_at > 1) failing.push_back(&curve);
  }
  const auto ratio = [&](const ThinningCurve& curve) {
    const auto at = std::find(method.keep_every.begin(), method.keep_every.end(), curve.fails_at);
    return curve.error[at - method.keep_every.begin()] / curve.error.front();
  };
  std::stable_sort(failing.begin(), failing.end(), [&](const auto* a, const auto* b) {
    return a->fails_at != b->fails_at ? a->fails_at < b->fails_at : ratio(*a) > ratio(*b);
  });
  if (failing.empty()) return;
  fmt::print("  {} first to fail:", metric.metric);
  for (std::size_t i = 0; i < std::min(kShown, failing.size()); ++i) {
    fmt::print("{} {} ({:.0f} %: x{:.2f})", i > 0 ? "," : "", failing[i]->material,
               100.0 / failing[i]->fails_at, ratio(*failing[i]));
  }
  fmt::print("{}\n", failing.size() > kShown ? ", ..." : "");
}

}  // namespace

std::vector<MethodSummary> Summarise(const StudyResult& study) {
  std::vector<MethodSummary> summaries;
  for (const std::string& method :
       Names(study, [](const StudyCell& cell) { return cell.method; })) {
    summaries.push_back(Summary(study, method).Take());
  }
  return summaries;
}

json ToJson(const MethodSummary& summary) {
  return {{"method", summary.method},
          {"keep_every", summary.keep_every},
          {"male", ToJson(summary.male)},
          {"table_mse", ToJson(summary.mse)}};
}

void Print(const MethodSummary& summary) {
  std::vector<std::string> densities;
  for (const int every : summary.keep_every)
    densities.push_back(fmt::format("{:.3g} %", 100.0 / every));
  fmt::print("{}\n", summary.method);
  PrintRow("density", densities);
  for (const MetricSummary* metric : {&summary.male, &summary.mse}) {
    PrintRow("median " + metric->metric, Shown(metric->median));
    PrintRow("mean " + metric->metric, Shown(metric->mean));
    std::vector<std::string> within;
    for (const int count : metric->within) within.push_back(fmt::format("{}", count));
    PrintRow(fmt::format("{} within x{}", metric->metric, kHoldsWithin), within);
  }
  for (const MetricSummary* metric : {&summary.male, &summary.mse}) {
    fmt::print("  {} stays within x{} down to {:.0f} % of the density: {} of {} materials\n",
               metric->metric, kHoldsWithin, 100 * kHoldsDownTo, metric->holds,
               metric->curves.size());
    PrintFirstToFail(summary, *metric);
  }
}

}  // namespace gonio
