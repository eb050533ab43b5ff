// SPDX-License-Identifier: Apache-2.0
// gonio compare: every metric between two reflectances of any kind.

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "apps/gonio/commands.h"
#include "apps/gonio/json_file.h"
#include "apps/gonio/locate.h"
#include "apps/gonio/open_any.h"
#include "apps/gonio/summary.h"
#include "brdf/metrics.h"
#include "core/error.h"
#include "core/units.h"

namespace gonio {
namespace {

void Print(const ErrorMetrics& m) {
  fmt::print("MALE              {:<12.6g}  red {:.6g}, green {:.6g}, blue {:.6g}\n", m.male,
             m.male_per_channel[0], m.male_per_channel[1], m.male_per_channel[2]);
  fmt::print("log-relative RMS  {:.6g}\n", m.log_relative_rms);
  fmt::print("MSE               {:<12.6g}  1/sr^2\n", m.mse);
  fmt::print("RMS               {:<12.6g}  1/sr\n", m.rms);
  fmt::print("cube-root RMS     {:.6g}\n", m.cube_root_rms);
  fmt::print("log MSE           {:.6g}\n", m.log_mse);
  fmt::print("cells             {} compared, {} missing in the second\n", m.compared, m.missing);
}

nlohmann::json ToJson(const ErrorMetrics& m) {
  return {
      {"male", m.male},
      {"male_per_channel", {m.male_per_channel[0], m.male_per_channel[1], m.male_per_channel[2]}},
      {"log_relative_rms", m.log_relative_rms},
      {"mse", m.mse},
      {"rms", m.rms},
      {"cube_root_rms", m.cube_root_rms},
      {"log_mse", m.log_mse},
      {"compared", m.compared},
      {"missing", m.missing}};
}

}  // namespace

int CompareCommand(const CompareOptions& options) {
  const std::unique_ptr<Brdf> reference = OpenAny(LocateConfig(options.reference.string()));
  const std::unique_ptr<Brdf> other = OpenAny(LocateConfig(options.other.string()));
  MetricOptions metric_options = AllCores();
  metric_options.max_theta = RadFromDeg(options.max_theta_deg);
  metric_options.phi_stride = options.phi_stride;
  const ErrorMetrics metrics = Compare(*reference, *other, metric_options);
  if (metrics.compared == 0) {
    throw ConfigError(fmt::format("{}: knows no cell where {} has a value", options.other.string(),
                                  options.reference.string()));
  }
  if (options.json != "-") Print(metrics);
  if (!options.json.empty()) {
    nlohmann::json json = ToJson(metrics);
    json["reference"] = options.reference.string();
    json["other"] = options.other.string();
    json["max_theta_deg"] = options.max_theta_deg;
    json["phi_stride"] = options.phi_stride;
    WriteJson(options.json, json);
  }
  return kDone;
}

}  // namespace gonio
