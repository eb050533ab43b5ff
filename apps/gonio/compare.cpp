// SPDX-License-Identifier: Apache-2.0
// gonio compare: every metric between two reflectances of any kind.

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <optional>
#include <vector>

#include "apps/gonio/commands.h"
#include "apps/gonio/json_file.h"
#include "apps/gonio/locate.h"
#include "apps/gonio/open_any.h"
#include "apps/gonio/summary.h"
#include "apps/gonio/tabulate.h"
#include "brdf/metrics.h"
#include "brdf/render/environment.h"
#include "brdf/render/image_metrics.h"
#include "brdf/render/sphere.h"
#include "brdf/sample_metrics.h"
#include "brdf/samples_csv.h"
#include "core/error.h"
#include "core/units.h"

namespace gonio {
namespace {

void Print(const ErrorMetrics& m) {
  fmt::print("MALE              {:<12.6g}  red {:.6g}, green {:.6g}, blue {:.6g}\n", m.male,
             m.male_per_channel[0], m.male_per_channel[1], m.male_per_channel[2]);
  fmt::print("log-relative RMS  {:.6g}\n", m.log_relative_rms);
  fmt::print("MSE               {:<12.6g}  1/sr^2; over the whole table {:.6g}\n", m.mse,
             m.table_mse);
  fmt::print("RMS               {:<12.6g}  1/sr\n", m.rms);
  fmt::print("cube-root RMS     {:.6g}\n", m.cube_root_rms);
  fmt::print("log MSE           {:.6g}\n", m.log_mse);
  fmt::print("cells             {} compared, {} missing in the second\n", m.compared, m.missing);
}

// The two spheres that people judge reflectance by.
struct RenderDifferences {
  ImageDifference point, environment;
};

RenderDifferences CompareRenders(const Brdf& reference, const Brdf& other) {
  RenderOptions options;
  options.size = 192;  // noise is alike in both and hardly counts
  options.samples = 192;
  options.threads = AllCores().threads;
  const MerlTable a = Tabulate(reference);
  const MerlTable b = Tabulate(other);
  const auto compare = [](const Image& one, const Image& two) {
    return CompareImages(one, two, AutoExposure(one));
  };
  const Environment sky = Environment::Sky();
  return {compare(RenderUnderPoint(a, options), RenderUnderPoint(b, options)),
          compare(RenderUnder(a, sky, options), RenderUnder(b, sky, options))};
}

void Print(const char* light, const ImageDifference& d) {
  fmt::print("render, {:<9} dE_ITP {:.3g}, PSNR {:.2f} dB, SSIM {:.4f}, FLIP {:.4f}\n", light,
             d.delta_e_itp, d.psnr_db, d.ssim, d.flip);
}

nlohmann::json ToJson(const ImageDifference& d) {
  nlohmann::json json = {{"delta_e_itp", d.delta_e_itp}, {"ssim", d.ssim}, {"flip", d.flip}};
  // JSON knows no infinity: equal images have none.
  json["psnr_db"] = std::isfinite(d.psnr_db) ? nlohmann::json(d.psnr_db) : nlohmann::json(nullptr);
  return json;
}

nlohmann::json ToJson(const ErrorMetrics& m) {
  return {
      {"male", m.male},
      {"table_mse", m.table_mse},
      {"male_per_channel", {m.male_per_channel[0], m.male_per_channel[1], m.male_per_channel[2]}},
      {"log_relative_rms", m.log_relative_rms},
      {"mse", m.mse},
      {"rms", m.rms},
      {"cube_root_rms", m.cube_root_rms},
      {"log_mse", m.log_mse},
      {"compared", m.compared},
      {"missing", m.missing}};
}

// A reference that is known at some poses only.
int CompareWithSamples(const CompareOptions& options) {
  std::vector<BrdfSample> samples;
  for (const MeasuredSample& row : ReadSamplesCsv(options.reference)) {
    samples.push_back(row.sample);
  }
  const std::unique_ptr<Brdf> other = OpenAny(LocateConfig(options.other.string()));
  const SampleMetrics m = CompareSamples(samples, *other, RadFromDeg(options.max_theta_deg));
  if (m.readings == 0) {
    throw ConfigError(options.reference.string() + ": has no sample that can be compared");
  }
  if (options.json != "-") {
    fmt::print("MALE              {:.6g}\n", m.male);
    fmt::print("log-relative RMS  {:.6g}\n", m.log_relative_rms);
    fmt::print("RMS               {:<12.6g}  1/sr\n", m.rms);
    fmt::print("RMS / sigma       {:.6g}\n", m.z_rms);
    fmt::print("readings          {} compared, {} left out\n", m.readings, m.left_out);
  }
  if (!options.json.empty()) {
    WriteJson(options.json, {{"male", m.male},
                             {"log_relative_rms", m.log_relative_rms},
                             {"rms", m.rms},
                             {"z_rms", m.z_rms},
                             {"readings", m.readings},
                             {"left_out", m.left_out},
                             {"reference", options.reference.string()},
                             {"other", options.other.string()},
                             {"max_theta_deg", options.max_theta_deg}});
  }
  return kDone;
}

}  // namespace

int CompareCommand(const CompareOptions& options) {
  if (options.reference.extension() == ".csv") return CompareWithSamples(options);
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
  const bool print = options.json != "-";
  if (print) Print(metrics);
  std::optional<RenderDifferences> renders;
  if (options.render) renders = CompareRenders(*reference, *other);
  if (print && renders) {
    Print("point", renders->point);
    Print("sky", renders->environment);
  }
  if (!options.json.empty()) {
    nlohmann::json json = ToJson(metrics);
    if (renders) {
      json["render_point"] = ToJson(renders->point);
      json["render_env"] = ToJson(renders->environment);
    }
    json["reference"] = options.reference.string();
    json["other"] = options.other.string();
    json["max_theta_deg"] = options.max_theta_deg;
    json["phi_stride"] = options.phi_stride;
    WriteJson(options.json, json);
  }
  return kDone;
}

}  // namespace gonio
