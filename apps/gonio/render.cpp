// SPDX-License-Identifier: Apache-2.0
// gonio render: spheres of reflectances.

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <chrono>
#include <cmath>
#include <memory>
#include <optional>
#include <thread>

#include "apps/gonio/commands.h"
#include "apps/gonio/locate.h"
#include "apps/gonio/open_any.h"
#include "apps/gonio/tabulate.h"
#include "brdf/render/sphere.h"
#include "core/error.h"

namespace gonio {
namespace {

bool IsPng(const std::filesystem::path& path) { return path.extension() == ".png"; }

// What can be said before anything is rendered. The exposure, or none for "auto".
std::optional<double> Check(const RenderCommandOptions& options) {
  for (const std::filesystem::path& out : options.outs) {
    const std::string extension = out.extension().string();
    if (extension != ".png" && extension != ".hdr" && extension != ".exr") {
      throw ConfigError(fmt::format("{}: has the extension \"{}\", must be .png, .hdr or .exr",
                                    out.string(), extension));
    }
  }
  if (!options.environment.empty() && options.light != "env") {
    throw ConfigError("--environment: needs --light env");
  }
  if (options.exposure == "auto") return std::nullopt;
  double exposure = 0;
  const char* end = options.exposure.data() + options.exposure.size();
  const auto [parsed, error] = std::from_chars(options.exposure.data(), end, exposure);
  if (error != std::errc() || parsed != end || !(exposure > 0 && std::isfinite(exposure))) {
    throw ConfigError(
        fmt::format("--exposure: is \"{}\", must be auto or a number > 0", options.exposure));
  }
  return exposure;
}

// `images` beside each other.
Image Row(const std::vector<Image>& images) {
  Image row(images[0].width * static_cast<int>(images.size()), images[0].height);
  for (std::size_t i = 0; i < images.size(); ++i) {
    for (int y = 0; y < row.height; ++y) {
      for (int x = 0; x < images[i].width; ++x) {
        row.at(static_cast<int>(i) * images[i].width + x, y) = images[i].at(x, y);
      }
    }
  }
  return row;
}

}  // namespace

int RenderCommand(const RenderCommandOptions& options) {
  const std::optional<double> asked = Check(options);
  RenderOptions render;
  render.size = options.size;
  render.samples = options.samples;
  render.threads = static_cast<int>(std::max(1u, std::thread::hardware_concurrency()));
  std::optional<Environment> environment;
  if (options.light == "env") {
    environment =
        options.environment.empty() ? Environment::Sky() : Environment::Read(options.environment);
  }
  std::vector<std::unique_ptr<Brdf>> brdfs;
  for (const std::string& input : options.inputs) brdfs.push_back(OpenAny(LocateConfig(input)));

  const auto begin = std::chrono::steady_clock::now();
  std::vector<Image> images;
  for (const auto& brdf : brdfs) {
    const MerlTable table = Tabulate(*brdf);
    images.push_back(environment ? RenderUnder(table, *environment, render)
                                 : RenderUnderPoint(table, render));
  }
  const std::chrono::duration<double> took = std::chrono::steady_clock::now() - begin;
  const double exposure = asked.value_or(AutoExposure(images[0]));
  const Image row = Row(images);
  fmt::print("rendered         {} x {} pixels in {:.1f} s, exposure {:.4g}\n", row.width,
             row.height, took.count(), exposure);
  for (const std::filesystem::path& out : options.outs) {
    if (IsPng(out)) {
      WritePng(out, ToneMap(row, exposure));
    } else {
      WriteImage(out, row);
    }
    fmt::print("wrote            {}\n", out.string());
  }
  return kDone;
}

}  // namespace gonio
