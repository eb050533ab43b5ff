// SPDX-License-Identifier: Apache-2.0
#include "apps/gonio/frontier_summary.h"

#include <gmock/gmock.h>

#include <cmath>

#include "apps/gonio/frontier_figures.h"
#include "apps/gonio/frontier_score.h"
#include "apps/gonio/statistics.h"
#include "brdf/merl_table.h"
#include "core/units.h"

namespace gonio {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

TEST(Quantile, InterpolatesLeavesNanOutAndKeepsInfinity) {
  EXPECT_DOUBLE_EQ(Median({3, 1, 2}), 2);
  EXPECT_DOUBLE_EQ(Median({4, 1, FrontierRow::kUnknown}), 2.5);
  EXPECT_DOUBLE_EQ(Quantile({0, 10}, 0.9), 9);
  EXPECT_EQ(Quantile({1, 2, kInfinity}, 0.5), 2);
  EXPECT_EQ(Quantile({1, 2, kInfinity}, 0.9), kInfinity);
  EXPECT_TRUE(std::isnan(Median({})));
}

FrontierRow Row(int poses, double minutes, double male) {
  FrontierRow row;
  row.budget = row.poses = poses;
  row.minutes = minutes;
  row.male = male;
  return row;
}

TEST(FindCrossing, InterpolatesOnLogarithmicAxes) {
  const std::vector<FrontierRow> rows = {Row(10, 2, 0.04), Row(40, 8, 0.01), Row(80, 32, 0.005)};
  const auto crossing = FindCrossing(rows, 0.02);
  ASSERT_TRUE(crossing);
  EXPECT_NEAR(crossing->poses, 20, 1e-9);
  EXPECT_NEAR(crossing->minutes, 4, 1e-9);
  EXPECT_NEAR(FindCrossing(rows, 0.5)->poses, 10, 1e-9);
  EXPECT_FALSE(FindCrossing(rows, 0.001));
}

FrontierCell Cell(const std::string& material, double male, double coverage) {
  FrontierCell cell;
  cell.material = material;
  cell.contestant = "one";
  cell.noise = "none";
  cell.rows = {Row(10, 1, 2 * male), Row(20, 2, male)};
  cell.rows[1].coverage = {0.5, coverage, 0.97};
  return cell;
}

TEST(Summarise, CountsCalibratedSessionsNeedsAndHonestStops) {
  FrontierResult result;
  result.cells = {Cell("a", 0.01, 0.9), Cell("b", 0.02, 0.5), Cell("c", 0.03, 0.86)};
  result.cells[0].stops = {{.target = 0.015, .poses = 15, .minutes = 1.5, .male = 0.014}};
  result.cells[1].stops = {{.target = 0.015, .poses = 17, .minutes = 1.7, .male = 0.02}};
  result.cells[2].stops = {{.target = 0.015}};
  for (const char* name : {"a", "b", "c"}) result.dense.push_back({name, false, "", 0.02});
  const std::vector<ContestantSummary> summaries = Summarise(result);
  ASSERT_EQ(summaries.size(), 1u);
  const ContestantSummary& summary = summaries[0];
  EXPECT_DOUBLE_EQ(summary.budgets[1].mean, 0.02);
  EXPECT_DOUBLE_EQ(summary.budgets[1].median, 0.02);
  EXPECT_NEAR(summary.budgets[1].coverage[kNinety], (0.9 + 0.5 + 0.86) / 3, 1e-12);
  EXPECT_NEAR(summary.budgets[1].share_calibrated, 2.0 / 3, 1e-12);
  EXPECT_TRUE(std::isnan(summary.budgets[0].share_calibrated));
  EXPECT_EQ(summary.poses.count, 3);
  EXPECT_EQ(summary.poses.never, 1);  // c
  EXPECT_GT(summary.poses.median, 10);
  EXPECT_LT(summary.poses.median, 20);
  EXPECT_EQ(summary.poses.q90, kInfinity);
  ASSERT_EQ(summary.stops.size(), 1u);
  EXPECT_EQ(summary.stops[0].sessions, 3);
  EXPECT_EQ(summary.stops[0].stopped, 2);
  EXPECT_EQ(summary.stops[0].honest, 1);
  EXPECT_DOUBLE_EQ(summary.stops[0].poses, 16);
}

class Flat : public Brdf {
 public:
  using Brdf::Eval;
  std::optional<Rgb> Eval(const HalfDiff&) const override { return Rgb(0.1, 0.2, 0.3); }
  std::string name() const override { return "flat"; }
};

// Right in one channel, and, in the two others, only for the widest interval.
class Guess : public Estimate {
 public:
  using Brdf::Eval;
  std::optional<Rgb> Eval(const HalfDiff&) const override { return Rgb::Constant(0.1); }
  std::string name() const override { return "guess"; }
  Prediction Predict(const HalfDiff&) const override { return {}; }
  Interval PredictInterval(const HalfDiff&, double probability) const override {
    return {Rgb::Constant(0.05), Rgb::Constant(probability > 0.92 ? 0.5 : 0.15)};
  }
};

TEST(Coverage, IsTheShareOfDirectionsAndChannelsInside) {
  const auto coverage = Coverage(Flat(), Guess(), {}, 6, 24);
  EXPECT_NEAR(coverage[0], 1.0 / 3, 1e-12);
  EXPECT_NEAR(coverage[kNinety], 1.0 / 3, 1e-12);
  EXPECT_NEAR(coverage[2], 1, 1e-12);
}

// Knows one direction only: the truth is inside there.
class Local : public Guess {
 public:
  Interval PredictInterval(const HalfDiff& x, double) const override {
    const bool here = std::abs(x.theta_h - kAt.theta_h) + std::abs(x.theta_d - kAt.theta_d) +
                          std::abs(x.phi_d - kAt.phi_d) <
                      1e-9;
    return {Rgb::Zero(), Rgb::Constant(here ? 1 : 0)};
  }
  static inline const HalfDiff kAt = MerlTable::CellCentre(45, 15, 72);
};

TEST(Coverage, LeavesOutWhatWasMeasured) {
  EXPECT_GT(Coverage(Flat(), Local(), {}, 6, 24)[0], 0);
  std::vector<BrdfSample> samples(1);
  samples[0].directions = ToDirections(Local::kAt);
  EXPECT_EQ(Coverage(Flat(), Local(), samples, 6, 24)[0], 0);
}

TEST(CoveragePlot, NamesAMaterialInItsOwnPanelAndIsNotDrawnWithoutIntervals) {
  FrontierResult result;
  result.cells = {Cell("a-material", 0.01, 0.9), Cell("another", 0.02, 0.5),
                  Cell("foreign", 0.02, 0.7)};
  result.cells[2].held_out = true;
  const auto plot = CoveragePlot(result);
  ASSERT_TRUE(plot);
  const std::string svg = RenderSvg(*plot, "c");
  for (const char* text : {"a-material", "another", "foreign", "held-out materials", ">one<"}) {
    const std::size_t at = svg.find(text);
    EXPECT_NE(at, std::string::npos) << text;
    EXPECT_EQ(svg.find(text, at + 1), std::string::npos) << text << " more than once";
  }
  // Tables of (column, share), a panel each.
  ASSERT_EQ(plot->tables.size(), 2u);
  EXPECT_EQ(plot->tables[0].rows, (std::vector<std::vector<double>>{{0, 0.9}, {1, 0.5}}));
  EXPECT_EQ(plot->tables[1].rows, (std::vector<std::vector<double>>{{0, 0.7}}));
  for (FrontierCell& cell : result.cells) cell.rows[1].coverage = cell.rows[0].coverage;
  EXPECT_FALSE(CoveragePlot(result));
}

TEST(FrontierPlot, DrawsProcessesLastAndNamesAllInTheStudysOrder) {
  FrontierResult result;
  result.cells = {Cell("a", 0.01, 0.9), Cell("a", 0.02, 0.9)};
  result.cells[1].contestant = "rival";
  result.cells[1].rows[1].coverage = result.cells[1].rows[0].coverage;
  const Plot plot = FrontierPlot(result, Summarise(result), Cost::kPoses);
  ASSERT_EQ(plot.tables.size(), 2u);
  EXPECT_EQ(plot.tables[0].rows[1][1], 0.02);
  EXPECT_EQ(plot.tables[1].rows[1][1], 0.01);
  const std::string svg = RenderSvg(plot, "f");
  EXPECT_LT(svg.find(">one<"), svg.find(">rival<"));
  EXPECT_NE(svg.find(">rival<"), std::string::npos);
}

}  // namespace
}  // namespace gonio
