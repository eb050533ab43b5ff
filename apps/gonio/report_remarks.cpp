// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>

#include "apps/gonio/report_imported.h"
#include "apps/gonio/report_page.h"

namespace gonio {
namespace {

// Beyond this the lobes miss something a reader would see.
constexpr double kLargeModelError = 0.1;
// Expected and true error are both estimates of a mean: factors below this are no news.
constexpr double kLargeMisjudgement = 2;

using Sentences = std::vector<std::string>;

void RemarkOnEnd(const ReportFacts& facts, Sentences* remarks) {
  const auto& end = facts.session.end;
  if (!end) {
    remarks->push_back(
        "The session has not ended in its log: it is still running, was killed, or ran out of "
        "disk. This page shows what the log holds.");
  } else if (end->outcome != "complete") {
    remarks->push_back(fmt::format("The session ended early ({}): {}.", end->outcome, end->reason));
  }
  for (const std::string& error : facts.device_errors) {
    remarks->push_back("Device error: " + error + ".");
  }
  if (!facts.incidents.empty()) {
    remarks->push_back(fmt::format(
        "{} {} between the poses, such as failures, interlocks or pauses; "
        "see the list near the end.",
        facts.incidents.size(), facts.incidents.size() == 1 ? "thing came" : "things came"));
  }
}

void RemarkOnPoses(const ReportFacts& facts, Sentences* remarks) {
  if (!facts.refusals.empty()) {
    remarks->push_back(fmt::format("{} {} refused; see the list at the end.", facts.refusals.size(),
                                   facts.refusals.size() == 1 ? "pose was" : "poses were"));
  }
  int retries = 0;
  for (const MeasuredPose& pose : facts.session.poses) retries += pose.move_retries;
  if (retries > 0) {
    remarks->push_back(fmt::format("{} {} repeated because an axis had missed its target.", retries,
                                   retries == 1 ? "move was" : "moves were"));
  }
  if (const int negative = NegativeSamples(facts.session); IsImported(facts) && negative > 0) {
    remarks->push_back(fmt::format(
        "{} of {} samples are below zero in some channel. They are readings like the others: kept, "
        "fitted and shown.",
        negative, facts.session.Samples().size()));
  }
  if (const int lost = LostReadings(facts.session); lost > 0 && IsImported(facts)) {
    remarks->push_back(fmt::format(
        "{} of {} channel readings are marked as unusable and not fitted: where light and detector "
        "are too near to each other one shadows the other.",
        lost, kChannels * facts.session.Samples().size()));
  } else if (lost > 0) {
    remarks->push_back(fmt::format(
        "{} of {} channel readings saturated in every frame and were left out of the fit.", lost,
        kChannels * facts.session.poses.size()));
  }
}

void RemarkOnFit(const ReportFacts& facts, Sentences* remarks) {
  if (!facts.fit) {
    remarks->push_back("There is no fit: " + facts.no_fit + ".");
    return;
  }
  const FitSummary& fit = facts.fit->summary();
  if (!fit.converged) remarks->push_back("The fit did not converge: " + fit.reason + ".");
  if (fit.model_error > kLargeModelError) {
    remarks->push_back(
        fmt::format("Model error {:.0f} %: the lobes do not describe this material well, and the "
                    "bands count that in.",
                    100 * fit.model_error));
  }
}

void RemarkOnTruth(const ReportFacts& facts, Sentences* remarks) {
  const SessionInfo& info = facts.session.info;
  if (!facts.truth && !info.material_path.empty()) {
    remarks->push_back("Truth not available: " + facts.no_truth + ".");
  }
  if (!facts.no_true_error.empty()) {
    remarks->push_back("The true error after fewer poses is not known: " + facts.no_true_error +
                       ".");
  }
  if (!facts.male || facts.planner_error.empty()) return;
  if (facts.plan.information.gain.objective != Objective::kMale) return;
  const double expected = facts.planner_error.back().error;
  if (*facts.male > kLargeMisjudgement * expected) {
    remarks->push_back(
        fmt::format("The true error is {:.1f} times what the planner expected: on this material "
                    "its uncertainty is too small.",
                    *facts.male / expected));
  }
}

}  // namespace

std::vector<std::string> Remarks(const ReportFacts& facts) {
  Sentences remarks;
  RemarkOnEnd(facts, &remarks);
  RemarkOnPoses(facts, &remarks);
  RemarkOnFit(facts, &remarks);
  RemarkOnTruth(facts, &remarks);
  return remarks;
}

}  // namespace gonio
