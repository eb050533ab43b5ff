// SPDX-License-Identifier: Apache-2.0
#include "apps/gonio/simulate_answer.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "apps/gonio/statistics.h"

namespace gonio {
namespace {

using nlohmann::json;

constexpr double kNever = std::numeric_limits<double>::infinity();

std::string ToText(double number, int decimals) {
  if (std::isnan(number)) return "-";
  return std::isinf(number) ? "never" : fmt::format("{:.{}f}", number, decimals);
}

// How much less than `hours` these are.
std::string Saved(double taken, double hours) {
  return std::isinf(taken) || std::isnan(taken)
             ? "-"
             : fmt::format("{:.1f} %", 100 * (1 - taken / hours));
}

Attained Summarise(const std::vector<const SimulatedSession*>& sessions,
                   std::optional<Reached> SimulatedSession::*when) {
  Attained attained;
  std::vector<double> poses;
  std::vector<double> hours;
  for (const SimulatedSession* session : sessions) {
    const std::optional<Reached>& reached = session->*when;
    attained.sessions += reached ? 1 : 0;
    poses.push_back(reached ? reached->poses : kNever);
    hours.push_back(reached ? reached->after.count() / 3600 : kNever);
  }
  attained.poses = SpreadOf(poses);
  attained.hours = SpreadOf(hours);
  return attained;
}

json ToJson(const Spread& spread) {
  const auto finite = [](double x) { return std::isfinite(x) ? json(x) : json(nullptr); };
  return {{"median", finite(spread.median)},
          {"low", finite(spread.low)},
          {"high", finite(spread.high)}};
}

json ToJson(const Attained& attained, int sessions) {
  return {{"share", static_cast<double>(attained.sessions) / sessions},
          {"poses", ToJson(attained.poses)},
          {"hours", ToJson(attained.hours)}};
}

void PrintLine(const std::string& plan, const char* error, const Attained& attained, int sessions,
               const Scans& scans) {
  fmt::print("{:<20} {:<10} {:>9} {:>22} {:>26} {:>9} {:>9}\n", plan, error,
             fmt::format("{} of {}", attained.sessions, sessions), ToText(attained.poses, 0),
             ToText(attained.hours, 3), Saved(attained.hours.median, scans.dense_hours),
             Saved(attained.hours.median, scans.thinned_hours));
}

}  // namespace

Spread SpreadOf(const std::vector<double>& numbers) {
  return {Median(numbers), Quantile(numbers, 0.1), Quantile(numbers, 0.9)};
}

std::string ToText(const Spread& spread, int decimals) {
  if (std::isnan(spread.median)) return "-";
  if (std::isinf(spread.low)) return "never";
  return fmt::format("{} ({} to {})", ToText(spread.median, decimals), ToText(spread.low, decimals),
                     ToText(spread.high, decimals));
}

std::vector<Answer> AnswersOf(const std::vector<SimulatedSession>& sessions) {
  std::vector<std::string> plans;
  for (const SimulatedSession& session : sessions) {
    if (std::find(plans.begin(), plans.end(), session.plan) == plans.end()) {
      plans.push_back(session.plan);
    }
  }
  std::vector<Answer> answers;
  for (const std::string& plan : plans) {
    std::vector<const SimulatedSession*> its;
    std::vector<double> at_stop;
    for (const SimulatedSession& session : sessions) {
      if (session.plan != plan) continue;
      its.push_back(&session);
      at_stop.push_back(session.male_at_stop);
    }
    answers.push_back({.plan = plan,
                       .sessions = static_cast<int>(its.size()),
                       .by_predicted = Summarise(its, &SimulatedSession::by_predicted),
                       .by_true = Summarise(its, &SimulatedSession::by_true),
                       .male_at_stop = SpreadOf(at_stop)});
  }
  return answers;
}

json ToJson(const Answer& answer) {
  return {{"plan", answer.plan},
          {"sessions", answer.sessions},
          {"predicted", ToJson(answer.by_predicted, answer.sessions)},
          {"true", ToJson(answer.by_true, answer.sessions)},
          {"male_at_stop", ToJson(answer.male_at_stop)}};
}

void PrintAnswers(const std::vector<Answer>& answers, double target, const Scans& scans) {
  fmt::print("\nTo an error of {:g}: median and 80 % interval over materials and seeds\n", target);
  fmt::print("{:<20} {:<10} {:>9} {:>22} {:>26} {:>9} {:>9}\n", "plan", "error", "reached", "poses",
             "hours", "saved", "of 30 %");
  for (const Answer& answer : answers) {
    PrintLine(answer.plan, "predicted", answer.by_predicted, answer.sessions, scans);
    PrintLine("", "true", answer.by_true, answer.sessions, scans);
    if (answer.by_predicted.sessions > 0) {
      fmt::print("{:<20} where the rig would stop the true error is {}\n", "",
                 ToText(answer.male_at_stop, 5));
    }
    const int missed = answer.sessions - answer.by_predicted.sessions;
    if (missed > 0) {
      fmt::print("{:<20} in {} of {} sessions the rig would not stop within the plan's budget\n",
                 "", missed, answer.sessions);
    }
  }
}

}  // namespace gonio
