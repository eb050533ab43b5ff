// SPDX-License-Identifier: Apache-2.0
#include "acquisition/event_bodies.h"

#include <cmath>
#include <nlohmann/json.hpp>

#include "core/units.h"

namespace gonio {

using nlohmann::json;

namespace {

// Null where nothing was measured.
json ColoursOf(const Rgb& values) {
  json colours = json::array();
  for (const double value : values) colours.push_back(std::isfinite(value) ? json(value) : json());
  return colours;
}

}  // namespace

json ToJson(const MeasurerState& state) {
  json body = {{"told_rad", state.told}};
  if (state.exposure) body["exposure_s"] = state.exposure->count();
  if (state.colour) {
    body["colour"] = ToString(*state.colour);
    json& rates = body["rates_per_s"] = json::array();
    for (const std::optional<double>& rate : state.rates)
      rates.push_back(rate ? json(*rate) : json());
  }
  return body;
}

json DegreesOf(const HalfDiff& angles) {
  return {{"theta_h_deg", DegFromRad(angles.theta_h)},
          {"theta_d_deg", DegFromRad(angles.theta_d)},
          {"phi_d_deg", DegFromRad(angles.phi_d)}};
}

json BudgetOf(const ReducedSample& reduced) {
  json terms = json::object();
  for (int i = 0; i < kUncertaintyTerms; ++i) {
    const auto term = static_cast<UncertaintyTerm>(i);
    const Rgb& sigma = reduced.budget[term];
    if ((sigma == 0).all()) continue;
    json colours = json::array();
    for (int c = 0; c < kChannels; ++c) {
      const bool measured = std::isfinite(reduced.sample.sigma[c]) && std::isfinite(sigma[c]);
      colours.push_back(measured ? json(sigma[c]) : json());
    }
    terms[ToString(term)] = colours;
  }
  return terms;
}

json BodyOf(const ReferenceRecord& visit) {
  const PoseRecord& record = visit.record;
  json frames = json::array();
  for (std::size_t k = 0; k < record.exposures.size(); ++k) {
    const Exposure& e = record.exposures[k];
    frames.push_back({{"exposure_s", e.frame.exposure.count()},
                      {"start_s", e.frame.start.count()},
                      {"monitor", e.monitor},
                      {"saturated", e.saturated},
                      {"mean_counts", ColoursOf(visit.net[k])}});
    if (e.colour) frames.back()["colour"] = ToString(*e.colour);
  }
  return {{"visit", visit.visit},
          {"poses", visit.poses},
          {"readback_rad", record.readback},
          {"frames", frames},
          {"time_s", visit.read.time.count()},
          {"signal_per_sr", ColoursOf(visit.read.signal)},
          {"sigma_per_sr", ColoursOf(visit.read.sigma)},
          {"ratio", ColoursOf(visit.ratio)},
          {"ratio_sigma", ColoursOf(visit.ratio_sigma)},
          {"gain", ColoursOf(visit.gain.value)},
          {"gain_sigma", ColoursOf(visit.gain.sigma)}};
}

}  // namespace gonio
