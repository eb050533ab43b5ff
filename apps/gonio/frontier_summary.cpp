// SPDX-License-Identifier: Apache-2.0
#include "apps/gonio/frontier_summary.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "apps/gonio/statistics.h"

namespace gonio {
namespace {

using Cells = std::vector<const FrontierCell*>;

// `text` once, in the order in which texts first appear.
void AddOnce(const std::string& text, std::vector<std::string>* texts) {
  if (std::find(texts->begin(), texts->end(), text) == texts->end()) texts->push_back(text);
}

bool IsCalibrated(double coverage) {
  return coverage >= kCalibratedFrom && coverage <= kCalibratedTo;
}

BudgetSummary SummariseBudget(const Cells& cells, std::size_t i) {
  std::vector<double> male, minutes, calibrated;
  std::array<std::vector<double>, kIntervals.size()> coverage;
  BudgetSummary summary;
  for (const FrontierCell* cell : cells) {
    if (i >= cell->rows.size()) continue;
    const FrontierRow& row = cell->rows[i];
    summary.budget = row.budget;
    if (!row.failure.empty()) continue;
    male.push_back(row.male);
    minutes.push_back(row.minutes);
    for (std::size_t k = 0; k < kIntervals.size(); ++k) coverage[k].push_back(row.coverage[k]);
    if (std::isfinite(row.coverage[kNinety])) {
      calibrated.push_back(IsCalibrated(row.coverage[kNinety]) ? 1 : 0);
    }
  }
  summary.count = static_cast<int>(male.size());
  summary.mean = MeanOf(male);
  summary.median = Median(male);
  summary.q25 = Quantile(male, 0.25);
  summary.q75 = Quantile(male, 0.75);
  summary.q90 = Quantile(male, 0.9);
  summary.minutes = Median(minutes);
  for (std::size_t k = 0; k < kIntervals.size(); ++k) summary.coverage[k] = MeanOf(coverage[k]);
  summary.share_calibrated = MeanOf(calibrated);
  return summary;
}

Need ToNeed(const std::vector<double>& needs) {
  Need need;
  need.count = static_cast<int>(needs.size());
  need.never = static_cast<int>(
      std::count_if(needs.begin(), needs.end(), [](double x) { return !std::isfinite(x); }));
  need.median = Median(needs);
  need.q90 = Quantile(needs, 0.9);
  return need;
}

void SummariseNeeds(const Cells& cells, const std::map<std::string, double>& dense,
                    ContestantSummary* summary) {
  std::vector<double> poses, minutes;
  for (const FrontierCell* cell : cells) {
    const auto known = dense.find(cell->material);
    if (known == dense.end() || !cell->failure.empty()) continue;
    const auto crossing = FindCrossing(cell->rows, kAsGoodAsDense * known->second);
    constexpr double kNever = std::numeric_limits<double>::infinity();
    poses.push_back(crossing ? crossing->poses : kNever);
    minutes.push_back(crossing ? crossing->minutes : kNever);
  }
  summary->poses = ToNeed(poses);
  summary->minutes = ToNeed(minutes);
}

StopSummary SummariseStops(const Cells& cells, std::size_t i) {
  StopSummary summary;
  std::vector<double> poses, minutes, male;
  for (const FrontierCell* cell : cells) {
    if (i >= cell->stops.size()) continue;
    const FrontierStop& stop = cell->stops[i];
    summary.target = stop.target;
    ++summary.sessions;
    if (stop.poses == 0) continue;
    ++summary.stopped;
    summary.honest += stop.male <= stop.target ? 1 : 0;
    poses.push_back(stop.poses);
    minutes.push_back(stop.minutes);
    male.push_back(stop.male);
  }
  summary.poses = Median(poses);
  summary.minutes = Median(minutes);
  summary.male = Median(male);
  return summary;
}

int CountFailures(const Cells& cells) {
  int failed = 0;
  for (const FrontierCell* cell : cells) {
    const bool row = std::any_of(cell->rows.begin(), cell->rows.end(),
                                 [](const FrontierRow& r) { return !r.failure.empty(); });
    failed += !cell->failure.empty() || row ? 1 : 0;
  }
  return failed;
}

ContestantSummary SummariseOne(const Cells& cells, const std::map<std::string, double>& dense) {
  ContestantSummary summary{.contestant = cells.front()->contestant,
                            .noise = cells.front()->noise,
                            .held_out = cells.front()->held_out,
                            .failed = CountFailures(cells)};
  std::size_t budgets = 0;
  std::size_t targets = 0;
  for (const FrontierCell* cell : cells) {
    budgets = std::max(budgets, cell->rows.size());
    targets = std::max(targets, cell->stops.size());
  }
  for (std::size_t i = 0; i < budgets; ++i) summary.budgets.push_back(SummariseBudget(cells, i));
  for (std::size_t i = 0; i < targets; ++i) summary.stops.push_back(SummariseStops(cells, i));
  SummariseNeeds(cells, dense, &summary);
  return summary;
}

}  // namespace

std::optional<Crossing> FindCrossing(const std::vector<FrontierRow>& rows, double error) {
  const FrontierRow* before = nullptr;
  for (const FrontierRow& row : rows) {
    if (!row.failure.empty() || !std::isfinite(row.male)) continue;
    if (row.male <= error) {
      const auto poses = static_cast<double>(row.poses);
      // A session that had enough before has nothing to interpolate with.
      if (before == nullptr || before->poses == row.poses) return Crossing{poses, row.minutes};
      const double share = std::log(before->male / error) / std::log(before->male / row.male);
      const auto between = [&](double a, double b) { return a * std::pow(b / a, share); };
      return Crossing{between(before->poses, poses), between(before->minutes, row.minutes)};
    }
    before = &row;
  }
  return std::nullopt;
}

std::vector<ContestantSummary> Summarise(const FrontierResult& result) {
  std::map<std::string, double> dense;
  for (const DenseCell& cell : result.dense) {
    if (std::isfinite(cell.male)) dense[cell.material] = cell.male;
  }
  std::vector<std::string> contestants, noises;
  for (const FrontierCell& cell : result.cells) {
    AddOnce(cell.contestant, &contestants);
    AddOnce(cell.noise, &noises);
  }
  std::vector<ContestantSummary> summaries;
  for (const bool held_out : {false, true}) {
    for (const std::string& noise : noises) {
      for (const std::string& contestant : contestants) {
        Cells cells;
        for (const FrontierCell& cell : result.cells) {
          if (cell.held_out == held_out && cell.noise == noise && cell.contestant == contestant) {
            cells.push_back(&cell);
          }
        }
        if (!cells.empty()) summaries.push_back(SummariseOne(cells, dense));
      }
    }
  }
  return summaries;
}

}  // namespace gonio
