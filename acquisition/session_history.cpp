// SPDX-License-Identifier: Apache-2.0
#include "acquisition/session_history.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "acquisition/light_colours.h"
#include "core/units.h"

namespace gonio {
namespace {

using nlohmann::json;

// Directions in the log are rounded to some 1e-15; other candidates are 1e-4 rad away or more.
constexpr double kSameDirection = 1e-7;  // rad
// Predicted errors: another compiler or processor may round otherwise.
constexpr double kSameNumber = 1e-9;

// Sessions of older versions do not say; what is left is where the arms were sent.
MeasurerState StateOf(const json& body, const AxisPositions& sent) {
  const auto found = body.find("after");
  if (found == body.end()) return {.told = sent, .exposure = {}};
  MeasurerState state{.told = found->at("told_rad").get<AxisPositions>(), .exposure = {}};
  if (found->contains("exposure_s")) {
    state.exposure = Seconds(found->at("exposure_s").get<double>());
  }
  if (found->contains("colour")) {
    state.colour = ColourNamed(found->at("colour").get<std::string>());
    for (std::size_t c = 0; c < state.rates.size(); ++c) {
      const json& rate = found->at("rates_per_s").at(c);
      if (!rate.is_null()) state.rates[c] = rate.get<double>();
    }
  }
  return state;
}

Rgb ColoursOf(const json& body, double instead_of_null) {
  Rgb colours;
  for (int c = 0; c < kChannels; ++c) {
    colours[c] = body.at(c).is_null() ? instead_of_null : body.at(c).get<double>();
  }
  return colours;
}

HalfDiff AnglesOf(const json& body) {
  return {RadFromDeg(body.at("theta_h_deg").get<double>()),
          RadFromDeg(body.at("theta_d_deg").get<double>()),
          RadFromDeg(body.at("phi_d_deg").get<double>())};
}

class HistoryReader {
 public:
  explicit HistoryReader(const SessionRecord& record) : record_(record) {
    history_.parts.push_back({0, record.info});
  }

  SessionHistory Read() {
    for (const SessionEvent& event : record_.events) {
      history_.end = std::max(history_.end, event.time);
      if (event.kind == "pose_measured") AddMeasured(json::parse(event.body));
      if (event.kind == "pose_rejected") AddRejected(json::parse(event.body));
      if (event.kind == "session_resumed") AddResume(json::parse(event.body));
      if (event.kind == "reference") AddVisit(event.time, json::parse(event.body));
      if (event.kind == "reference_refused") {
        history_.visits.push_back({poses_, event.time, std::nullopt});
      }
    }
    return std::move(history_);
  }

 private:
  void AddMeasured(const json& body) {
    const std::size_t i = body.at("pose").get<std::size_t>() - 1;
    if (i == record_.poses.size() && record_.unreduced) return;
    if (i >= record_.poses.size()) throw ConfigError("an event tells of a pose that is not there");
    const MeasuredPose& pose = record_.poses[i];
    poses_ = pose.pose;
    history_.measurer = StateOf(body, pose.commanded);
    history_.reference = history_.measurer->told;
    history_.turns.push_back({.proposal = {.directions = ToDirections(pose.planned),
                                           .candidate = pose.candidate,
                                           .score = pose.score.value_or(0),
                                           .reason = pose.reason,
                                           .frames = pose.frames_wanted},
                              .pose = pose.pose});
  }

  void AddRejected(const json& body) {
    if (body.contains("after")) history_.measurer = StateOf(body, {});
    history_.turns.push_back({.proposal = {.directions = ToDirections(AnglesOf(body)),
                                           .candidate = body.at("candidate").get<int>(),
                                           .score = 0,
                                           .reason = body.at("reason").get<std::string>(),
                                           .frames = body.value("frames_wanted", 1)},
                              .pose = 0});
  }

  void AddVisit(Seconds time, const json& body) {
    ReferenceVisit read;
    read.time = Seconds(body.at("time_s").get<double>());
    read.signal = ColoursOf(body.at("signal_per_sr"), 0);
    read.sigma = ColoursOf(body.at("sigma_per_sr"), std::numeric_limits<double>::infinity());
    history_.visits.push_back({body.at("poses").get<int>(), time, read});
    if (body.contains("after")) history_.measurer = StateOf(body, {});
  }

  // Only if something was changed do later turns follow from it.
  void AddResume(const json& body) {
    if (body.at("changes").empty()) return;
    history_.parts.push_back({static_cast<int>(history_.turns.size()),
                              InfoAfter(history_.parts.back().info, body.dump())});
  }

  const SessionRecord& record_;
  SessionHistory history_;
  int poses_ = 0;  // measured so far
};

std::string TextOf(const Proposal& p) {
  const HalfDiff at = ToHalfDiff(p.directions);
  return fmt::format("candidate {} (theta_h {:.3f}, theta_d {:.3f} deg, {}, {} frames)",
                     p.candidate, DegFromRad(at.theta_h), DegFromRad(at.theta_d), p.reason,
                     p.frames);
}

bool SameDirections(const DirectionPair& a, const DirectionPair& b) {
  return AngleBetween(a.wi, b.wi) < kSameDirection && AngleBetween(a.wo, b.wo) < kSameDirection;
}

bool Same(const Proposal& logged, const Proposal& now) {
  return logged.candidate == now.candidate && logged.frames == now.frames &&
         SameDirections(logged.directions, now.directions);
}

bool Same(const std::optional<double>& a, const std::optional<double>& b) {
  if (!a || !b) return a.has_value() == b.has_value();
  return std::abs(*a - *b) <= kSameNumber * std::abs(*a);
}

std::string TextOf(const std::optional<double>& number) {
  return number ? fmt::format("{:.9g}", *number) : "none";
}

// Follows a session with a planner, which is told what the session observed.
class Follower {
 public:
  Follower(const SessionRecord& record, const RigConfig& rig, Planner& planner)
      : record_(record), rig_(rig), planner_(planner) {}

  // What the planner says instead; empty: the same.
  std::string Ask(const LoggedTurn& turn, std::optional<Proposal>* next) {
    *next = planner_.Next();
    const std::string logged = "the log has " + TextOf(turn.proposal);
    if (!*next) return fmt::format("{}, the planner now ends: {}", logged, planner_.reason());
    if (!Same(turn.proposal, **next)) {
      return fmt::format("{}, the planner now wants {}", logged, TextOf(**next));
    }
    if (turn.pose == 0) return {};
    const std::optional<double>& before = record_.poses[turn.pose - 1].predicted_error;
    if (Same(before, planner_.PredictedError())) return {};
    return fmt::format("the log has a predicted error of {}, the planner now expects {}",
                       TextOf(before), TextOf(planner_.PredictedError()));
  }

  void Tell(const LoggedTurn& turn, const Proposal& proposal) {
    if (turn.pose == 0) {
      planner_.Reject(proposal);
      ++so_far_.summary.rejected;
      ++so_far_.rejections_in_a_row;
    } else {
      const MeasuredPose& pose = record_.poses[turn.pose - 1];
      planner_.Observe(proposal, pose.samples.front());
      Also(pose, 1);
      Add(pose);
    }
    ++so_far_.turns;
  }

  // As Tell(), where no candidate has its directions.
  void TellOfAnother(const LoggedTurn& turn) {
    if (turn.pose > 0) {
      Also(record_.poses[turn.pose - 1], 0);
      Add(record_.poses[turn.pose - 1]);
    }
    ++so_far_.turns;
  }

  SessionSoFar& so_far() { return so_far_; }

 private:
  void Also(const MeasuredPose& pose, std::size_t first) {
    for (std::size_t i = first; i < pose.samples.size(); ++i) planner_.AlsoObserve(pose.samples[i]);
  }

  void Add(const MeasuredPose& pose) {
    SessionSummary& summary = so_far_.summary;
    so_far_.rejections_in_a_row = 0;
    summary.travel += pose.move_time;
    summary.frames += pose.frames;
    summary.exposing += ColourChangesOf(rig_) + pose.exposed +
                        static_cast<double>(pose.frames) * rig_.camera.readout;
    summary.poses.push_back({pose.samples, pose.end, planner_.PredictedError()});
  }

  const SessionRecord& record_;
  const RigConfig& rig_;
  Planner& planner_;
  SessionSoFar so_far_;
};

void AddReference(const SessionRecord& record, const SessionHistory& history,
                  SessionSoFar* so_far) {
  so_far->measurer = history.measurer;
  so_far->visits = history.visits;
  if (record.poses.empty() || !history.reference) return;
  so_far->first = ToDirections(record.poses.front().planned);
  const MeasuredPose& last = record.poses.back();
  so_far->reference = {.pose = last.pose,
                       .arms = *history.reference,
                       .frames = last.frames_wanted,
                       .before = last.samples.front()};
}

}  // namespace

SessionHistory HistoryOf(const SessionRecord& record) {
  try {
    return HistoryReader(record).Read();
  } catch (const json::exception& e) {
    throw ConfigError(fmt::format("its events are damaged: {}", e.what()));
  }
}

CandidateIndex IndexIn(std::vector<Candidate> candidates) {
  return [candidates = std::move(candidates)](const DirectionPair& pair) {
    const auto found = std::find_if(candidates.begin(), candidates.end(), [&](const Candidate& c) {
      return SameDirections(c.directions, pair);
    });
    return found == candidates.end() ? -1 : static_cast<int>(found - candidates.begin());
  };
}

Retraced Retrace(const SessionRecord& record, const SessionHistory& history, const RigConfig& rig,
                 Planner& planner, const RetraceOptions& options) {
  Retraced result;
  Follower follower(record, rig, planner);
  bool follows = true;  // the planner has wanted the same so far
  const int turns = static_cast<int>(history.turns.size());
  for (int n = 0; n < std::min(turns, options.end); ++n) {
    const LoggedTurn& turn = history.turns[n];
    if (n == options.agree_from) follows = true;
    Proposal proposal = turn.proposal;
    if (follows) {
      std::optional<Proposal> next;
      const std::string what = follower.Ask(turn, &next);
      follows = what.empty();
      if (follows) proposal = *next;
      if (!follows && n >= options.agree_from) {
        result.first = {n, fmt::format("turn {}: {}", n + 1, what)};
        break;
      }
    }
    if (!follows) proposal.candidate = options.learn(proposal.directions);
    if (options.visit) options.visit(n, proposal);
    if (proposal.candidate >= 0) {
      follower.Tell(turn, proposal);
    } else {
      follower.TellOfAnother(turn);
    }
  }
  AddReference(record, history, &follower.so_far());
  result.so_far = std::move(follower.so_far());
  return result;
}

}  // namespace gonio
