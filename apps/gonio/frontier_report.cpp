// SPDX-License-Identifier: Apache-2.0
#include "apps/gonio/frontier_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "apps/gonio/statistics.h"

namespace gonio {
namespace {

std::string Error(double x) { return std::isfinite(x) ? fmt::format("{:.4f}", x) : "-"; }
std::string Percent(double x) { return std::isfinite(x) ? fmt::format("{:.0f} %", 100 * x) : "-"; }

// A quantile of needs: infinite where too many sessions never got there.
std::string Amount(double x, int decimals) {
  if (std::isnan(x)) return "-";
  return std::isinf(x) ? "never" : fmt::format("{:.{}f}", x, decimals);
}

std::string GroupOf(const ContestantSummary& summary) {
  return fmt::format("{}, noise {}", summary.held_out ? "held-out materials" : "cross-validated",
                     summary.noise);
}

// Runs of summaries of the same group, each given to `visit`.
template <typename Visit>
void ForEachGroup(const std::vector<ContestantSummary>& summaries, const Visit& visit) {
  for (std::size_t begin = 0; begin < summaries.size();) {
    std::size_t end = begin;
    while (end < summaries.size() && GroupOf(summaries[end]) == GroupOf(summaries[begin])) ++end;
    visit(std::vector<ContestantSummary>(summaries.begin() + static_cast<std::ptrdiff_t>(begin),
                                         summaries.begin() + static_cast<std::ptrdiff_t>(end)));
    begin = end;
  }
}

std::vector<std::string> BudgetHead(const ContestantSummary& summary) {
  std::vector<std::string> head = {"contestant"};
  for (const BudgetSummary& at : summary.budgets) head.push_back(fmt::format("n = {}", at.budget));
  return head;
}

// One number for each budget.
template <typename Cell>
TextTable BudgetTable(const std::string& title, const std::vector<ContestantSummary>& group,
                      const Cell& cell) {
  TextTable table{title + ", " + GroupOf(group.front()), BudgetHead(group.front()), {}};
  for (const ContestantSummary& summary : group) {
    std::vector<std::string> row = {summary.contestant};
    for (const BudgetSummary& at : summary.budgets) row.push_back(cell(at));
    table.rows.push_back(std::move(row));
  }
  return table;
}

TextTable NeedTable(const std::vector<ContestantSummary>& group) {
  TextTable table{
      fmt::format("To {} x the dense fit's error, {}", kAsGoodAsDense, GroupOf(group.front())),
      {"contestant", "poses, median", "90th percentile", "minutes, median", "90th percentile",
       "never"},
      {}};
  for (const ContestantSummary& s : group) {
    table.rows.push_back({s.contestant, Amount(s.poses.median, 0), Amount(s.poses.q90, 0),
                          Amount(s.minutes.median, 1), Amount(s.minutes.q90, 1),
                          fmt::format("{} of {}", s.poses.never, s.poses.count)});
  }
  return table;
}

TextTable StopTable(const std::vector<ContestantSummary>& group) {
  TextTable table{"Stopping at a predicted error, " + GroupOf(group.front()),
                  {"contestant", "target", "stopped", "at or below it", "poses, median",
                   "minutes, median", "MALE, median"},
                  {}};
  for (const ContestantSummary& s : group) {
    for (const StopSummary& stop : s.stops) {
      table.rows.push_back({s.contestant, fmt::format("{:g}", stop.target),
                            fmt::format("{} of {}", stop.stopped, stop.sessions),
                            stop.stopped > 0 ? Percent(double(stop.honest) / stop.stopped) : "-",
                            Amount(stop.poses, 0), Amount(stop.minutes, 1), Error(stop.male)});
    }
  }
  return table;
}

void AddCoverage(const std::vector<ContestantSummary>& group, std::vector<TextTable>* tables) {
  std::vector<ContestantSummary> sure;
  for (const ContestantSummary& summary : group) {
    const bool any =
        std::any_of(summary.budgets.begin(), summary.budgets.end(),
                    [](const BudgetSummary& at) { return std::isfinite(at.coverage[kNinety]); });
    if (any) sure.push_back(summary);
  }
  if (sure.empty()) return;
  for (std::size_t k = 0; k < kIntervals.size(); ++k) {
    tables->push_back(
        BudgetTable(fmt::format("Coverage of {:.0f} % intervals", 100 * kIntervals[k]), sure,
                    [&](const BudgetSummary& at) { return Percent(at.coverage[k]); }));
  }
  tables->push_back(
      BudgetTable(fmt::format("Sessions whose 90 % intervals hold {:.0f} to {:.0f} %",
                              100 * kCalibratedFrom, 100 * kCalibratedTo),
                  sure, [](const BudgetSummary& at) { return Percent(at.share_calibrated); }));
}

TextTable ReferenceTable(const FrontierResult& result) {
  std::vector<double> own, held_out;
  for (const DenseCell& cell : result.dense) {
    (cell.held_out ? held_out : own).push_back(cell.male);
  }
  TextTable table{fmt::format("Dense scan on the rig \"{}\"", result.rig),
                  {"", "poses", "hours", "mean MALE", "median MALE"},
                  {}};
  table.rows.push_back({"cross-validated materials", fmt::format("{}", result.dense_poses),
                        fmt::format("{:.2f}", result.dense_hours), Error(MeanOf(own)),
                        Error(Median(own))});
  if (!held_out.empty()) {
    table.rows.push_back(
        {"held-out materials", "", "", Error(MeanOf(held_out)), Error(Median(held_out))});
  }
  table.rows.push_back({"30 % of the rows", fmt::format("{}", result.thinned_poses),
                        fmt::format("{:.2f}", result.thinned_hours), "", ""});
  return table;
}

std::string MarkdownRow(const std::vector<std::string>& cells) {
  std::string line = "|";
  for (const std::string& cell : cells) line += " " + cell + " |";
  return line + "\n";
}

}  // namespace

std::vector<TextTable> MakeTables(const FrontierResult& result,
                                  const std::vector<ContestantSummary>& summaries) {
  std::vector<TextTable> tables = {ReferenceTable(result)};
  ForEachGroup(summaries, [&](const std::vector<ContestantSummary>& group) {
    const auto add = [&](const std::string& title, double BudgetSummary::*number) {
      tables.push_back(
          BudgetTable(title, group, [&](const BudgetSummary& at) { return Error(at.*number); }));
    };
    add("Mean MALE", &BudgetSummary::mean);
    add("Median MALE", &BudgetSummary::median);
    add("90th percentile of MALE", &BudgetSummary::q90);
    tables.push_back(BudgetTable("Minutes, median", group,
                                 [](const BudgetSummary& at) { return Amount(at.minutes, 1); }));
    tables.push_back(NeedTable(group));
    AddCoverage(group, &tables);
    TextTable stops = StopTable(group);
    if (!stops.rows.empty()) tables.push_back(std::move(stops));
  });
  return tables;
}

std::string ToPlainText(const TextTable& table) {
  std::vector<std::size_t> widths(table.head.size(), 0);
  const auto widen = [&](const std::vector<std::string>& row) {
    for (std::size_t i = 0; i < row.size(); ++i) widths[i] = std::max(widths[i], row[i].size());
  };
  widen(table.head);
  for (const auto& row : table.rows) widen(row);
  const auto line = [&](const std::vector<std::string>& row) {
    std::string text = fmt::format("  {:<{}}", row.front(), widths.front());
    for (std::size_t i = 1; i < row.size(); ++i) text += fmt::format("  {:>{}}", row[i], widths[i]);
    return text + "\n";
  };
  std::string text = table.title + "\n" + line(table.head);
  for (const auto& row : table.rows) text += line(row);
  return text;
}

std::string ToMarkdown(const FrontierResult& result, const std::vector<TextTable>& tables) {
  std::string text = fmt::format(
      "# {}\n\nErrors are MALE. Dense fits: `{}`, without noise. Times to {} x their error are "
      "interpolated between the budgets on logarithmic axes; a session that never gets there "
      "counts "
      "as infinite.\n",
      result.name, result.dense_method, kAsGoodAsDense);
  for (const TextTable& table : tables) {
    std::vector<std::string> rule = {"---"};
    rule.resize(table.head.size(), "---:");
    text += fmt::format("\n**{}**\n\n", table.title) + MarkdownRow(table.head) + MarkdownRow(rule);
    for (const auto& row : table.rows) text += MarkdownRow(row);
  }
  return text;
}

}  // namespace gonio
