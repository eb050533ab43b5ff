// SPDX-License-Identifier: Apache-2.0
#include "apps/gonio/frontier_json.h"

#include <cmath>
#include <nlohmann/json.hpp>

namespace gonio {
namespace {

using nlohmann::json;

struct Quantity {
  const char* name;
  double FrontierRow::*number;
};
constexpr Quantity kQuantities[] = {
    {"minutes", &FrontierRow::minutes},
    {"male", &FrontierRow::male},
    {"log_relative_rms", &FrontierRow::log_relative_rms},
    {"mse", &FrontierRow::mse},
    {"cube_root_rms", &FrontierRow::cube_root_rms},
    {"log_mse", &FrontierRow::log_mse},
    {"predicted_error", &FrontierRow::predicted_error},
};

json Number(double number) { return std::isfinite(number) ? json(number) : json(nullptr); }

double ToNumber(const json& number) {
  return number.is_null() ? FrontierRow::kUnknown : number.get<double>();
}

// Three numbers, or null where the first is not known.
json Coverage(const std::array<double, 3>& coverage) {
  return std::isfinite(coverage[0]) ? json(coverage) : json(nullptr);
}

json RowToJson(const FrontierRow& row) {
  json entry = {{"budget", row.budget}, {"poses", row.poses}, {"coverage", Coverage(row.coverage)}};
  for (const Quantity& quantity : kQuantities) entry[quantity.name] = Number(row.*quantity.number);
  if (!row.failure.empty()) entry["failure"] = row.failure;
  return entry;
}

FrontierRow RowFromJson(const json& entry) {
  FrontierRow row;
  row.budget = entry.at("budget");
  row.poses = entry.at("poses");
  if (!entry.at("coverage").is_null()) row.coverage = entry.at("coverage");
  for (const Quantity& quantity : kQuantities) {
    row.*quantity.number = ToNumber(entry.at(quantity.name));
  }
  row.failure = entry.value("failure", "");
  return row;
}

json StopToJson(const FrontierStop& stop) {
  return {{"target", stop.target},
          {"poses", stop.poses},
          {"minutes", Number(stop.minutes)},
          {"male", Number(stop.male)}};
}

FrontierStop StopFromJson(const json& entry) {
  return {.target = entry.at("target"),
          .poses = entry.at("poses"),
          .minutes = ToNumber(entry.at("minutes")),
          .male = ToNumber(entry.at("male"))};
}

json BudgetToJson(const BudgetSummary& at) {
  return {{"budget", at.budget},
          {"count", at.count},
          {"mean_male", Number(at.mean)},
          {"median_male", Number(at.median)},
          {"quantiles_male",
           {{"0.25", Number(at.q25)}, {"0.75", Number(at.q75)}, {"0.9", Number(at.q90)}}},
          {"median_minutes", Number(at.minutes)},
          {"coverage", Coverage(at.coverage)},
          {"share_calibrated", Number(at.share_calibrated)}};
}

json NeedToJson(const Need& need) {
  return {{"median", Number(need.median)},  // null: never
          {"0.9", Number(need.q90)},
          {"never", need.never},
          {"count", need.count}};
}

json StopsToJson(const StopSummary& stops) {
  return {{"target", stops.target},
          {"sessions", stops.sessions},
          {"stopped", stops.stopped},
          {"at_or_below_target", stops.honest},
          {"median_poses", Number(stops.poses)},
          {"median_minutes", Number(stops.minutes)},
          {"median_male", Number(stops.male)}};
}

}  // namespace

json ToJson(const FrontierCell& cell) {
  json rows = json::array();
  for (const FrontierRow& row : cell.rows) rows.push_back(RowToJson(row));
  json stops = json::array();
  for (const FrontierStop& stop : cell.stops) stops.push_back(StopToJson(stop));
  json entry = {{"material", cell.material},
                {"contestant", cell.contestant},
                {"noise", cell.noise},
                {"seed", cell.seed},
                {"held_out", cell.held_out},
                {"fold", cell.fold},
                {"rows", rows},
                {"stops", stops},
                {"cpu_s",
                 {{"session", cell.session_s},
                  {"reconstruction", cell.reconstruction_s},
                  {"scoring", cell.scoring_s}}}};
  if (!cell.failure.empty()) entry["failure"] = cell.failure;
  return entry;
}

FrontierCell FrontierCellFromJson(const json& entry) {
  FrontierCell cell;
  cell.material = entry.at("material");
  cell.contestant = entry.at("contestant");
  cell.noise = entry.at("noise");
  cell.seed = entry.at("seed");
  cell.held_out = entry.at("held_out");
  cell.fold = entry.at("fold");
  cell.failure = entry.value("failure", "");
  for (const json& row : entry.at("rows")) cell.rows.push_back(RowFromJson(row));
  for (const json& stop : entry.at("stops")) cell.stops.push_back(StopFromJson(stop));
  const json& cpu = entry.at("cpu_s");
  cell.session_s = cpu.at("session");
  cell.reconstruction_s = cpu.at("reconstruction");
  cell.scoring_s = cpu.at("scoring");
  return cell;
}

json ToJson(const DenseCell& cell) {
  json entry = {
      {"material", cell.material}, {"held_out", cell.held_out}, {"male", Number(cell.male)}};
  if (!cell.failure.empty()) entry["failure"] = cell.failure;
  return entry;
}

DenseCell DenseCellFromJson(const json& entry) {
  return {.material = entry.at("material"),
          .held_out = entry.at("held_out"),
          .failure = entry.value("failure", ""),
          .male = ToNumber(entry.at("male"))};
}

json ToJson(const ContestantSummary& summary) {
  json budgets = json::array();
  for (const BudgetSummary& at : summary.budgets) budgets.push_back(BudgetToJson(at));
  json stops = json::array();
  for (const StopSummary& at : summary.stops) stops.push_back(StopsToJson(at));
  return {{"contestant", summary.contestant},
          {"noise", summary.noise},
          {"held_out", summary.held_out},
          {"failed", summary.failed},
          {"budgets", budgets},
          {"poses_to_dense", NeedToJson(summary.poses)},
          {"minutes_to_dense", NeedToJson(summary.minutes)},
          {"stops", stops}};
}

}  // namespace gonio
