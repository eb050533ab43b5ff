// SPDX-License-Identifier: Apache-2.0
#include "acquisition/radiometry/calibration_file.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cmath>
#include <stdexcept>
#include <string_view>

#include "acquisition/radiometry/tiff_image.h"
#include "core/check.h"
#include "core/config.h"
#include "core/error.h"
#include "core/file.h"
#include "core/sha256.h"
#include "core/utc.h"

namespace gonio {
namespace {

constexpr const char* kFormat = "gonio-calibration";
constexpr int kVersion = 1;

ImageSize SizeOf(const SensorFormat& format) {
  return {format.width, format.height, CountsPerPixel(format.layout)};
}

double Finite(double number) {
  GONIO_CHECK(std::isfinite(number), "a calibration's numbers are finite");
  return number;
}

std::string HeaderText(const CalibrationData& data) {
  const SensorFormat& f = data.format;
  std::string text = fmt::format("format: {}\nversion: {}\nkind: {}\ncreated_utc: \"{}\"\n",
                                 kFormat, kVersion, data.kind, UtcText(data.created));
  text += fmt::format("camera: {}\nregion: [{}, {}, {}, {}]\npixel_layout: {}\nfull_scale: {}\n",
                      YamlQuoted(f.camera), f.left, f.top, f.width, f.height, ToString(f.layout),
                      f.full_scale);
  text += fmt::format("gain_db: {}\n", Finite(f.gain_db));
  if (data.temperature_c) text += fmt::format("temperature_c: {}\n", Finite(*data.temperature_c));
  if (!data.light.empty()) text += fmt::format("light: {}\n", YamlQuoted(data.light));
  return text;
}

std::string NumbersText(const CalibrationData& data) {
  std::string text;
  if (!data.texts.empty()) text += "texts:\n";
  for (const auto& [name, value] : data.texts) {
    text += fmt::format("  {}: {}\n", name, YamlQuoted(value));
  }
  if (!data.estimates.empty()) text += "estimates:\n";
  for (const auto& [name, e] : data.estimates) {
    text += fmt::format("  {}: [{}, {}]\n", name, Finite(e.value), Finite(e.sigma));
  }
  if (!data.lists.empty()) text += "lists:\n";
  for (const auto& [name, numbers] : data.lists) {
    GONIO_CHECK(!numbers.empty(), name);
    for (const double number : numbers) Finite(number);
    text += fmt::format("  {}: [{}]\n", name, fmt::join(numbers, ", "));
  }
  return text;
}

void WriteBytes(const std::filesystem::path& path, const std::string& bytes) {
  WriteFileAtomically(path, [&](std::ostream& out) { out << bytes; });
}

SensorFormat ReadFormat(const ConfigNode& root) {
  SensorFormat format;
  format.camera = root.Text("camera");
  const auto region = root.Numbers("region", 4, Range::Between(0, 1 << 20));
  format.left = static_cast<int>(region[0]);
  format.top = static_cast<int>(region[1]);
  format.width = static_cast<int>(region[2]);
  format.height = static_cast<int>(region[3]);
  format.layout = ReadPixelLayout(root, "pixel_layout");
  format.full_scale = root.Integer("full_scale", 1, 65535);
  format.gain_db = root.Number("gain_db");
  return format;
}

void CheckDemand(const ConfigNode& root, const CalibrationData& data,
                 const CalibrationDemand& demand) {
  const std::string difference = DifferenceOf(data.format, demand.format);
  if (!difference.empty()) throw ConfigError(root.file() + ": " + difference);
  if (demand.light && *demand.light != data.light) {
    const auto name = [](const std::string& light) {
      return light.empty() ? "one without colours" : light;
    };
    throw ConfigError(fmt::format("{}: light is {}, calibrated for {}", root.file(),
                                  name(*demand.light), name(data.light)));
  }
  const auto age = static_cast<double>(demand.now - data.created);
  if (age < 0) root.Fail("created_utc", "is in the future; a clock is wrong");
  if (age > demand.max_age) {
    root.Fail("created_utc", fmt::format("is {:.1f} days ago, the limit is {:.1f}", age / 86400,
                                         demand.max_age / 86400));
  }
  if (!data.temperature_c || !demand.temperature_c) return;
  const double off = std::abs(*data.temperature_c - *demand.temperature_c);
  if (!(off <= demand.max_temperature_difference)) {
    root.Fail("temperature_c", fmt::format("is {} degrees from the sensor's, the limit is {}", off,
                                           demand.max_temperature_difference));
  }
}

// All but the kind, which the caller judges.
CalibrationHeader ReadHeader(const ConfigNode& root) {
  root.Choice("format", {kFormat});
  root.Integer("version", kVersion, kVersion);
  CalibrationHeader header;
  header.kind = root.Text("kind");
  const auto created = SecondsOfUtc(root.Text("created_utc"));
  if (!created) root.Fail("created_utc", "must be like \"2024-05-03T09:12:44Z\"");
  header.created = *created;
  header.format = ReadFormat(root);
  if (root.Has("temperature_c")) header.temperature_c = root.Number("temperature_c");
  header.light = root.TextOr("light", "");
  return header;
}

SiteImage ReadSiteImage(const ConfigNode& node, const std::filesystem::path& folder,
                        const SensorFormat& format) {
  const std::string file = node.Text("file");
  if (file.find('/') != std::string::npos) node.Fail("file", "must lie beside this file");
  const std::filesystem::path path = folder / file;
  const std::string bytes = ReadTextFile(path);
  if (Sha256(bytes) != node.Text("sha256")) {
    throw ConfigError(fmt::format("{}: was changed since {} named it", path.string(), node.file()));
  }
  return DecodeTiffFloats(path, SizeOf(format), bytes);
}

}  // namespace

void WriteCalibration(const std::filesystem::path& path, const CalibrationData& data) {
  std::string text = HeaderText(data) + NumbersText(data);
  if (!data.images.empty()) text += "images:\n";
  for (const auto& [name, image] : data.images) {
    GONIO_CHECK(image.size() == data.format.sites(), "an image of all sites");
    const std::string bytes = EncodeTiff(path, SizeOf(data.format), image);
    const std::string digest = Sha256(bytes);
    const std::string file =
        fmt::format("{}.{}-{}.tiff", path.stem().string(), name, digest.substr(0, 8));
    WriteBytes(path.parent_path() / file, bytes);
    text += fmt::format("  {}: {{file: {}, sha256: \"{}\"}}\n", name, YamlQuoted(file), digest);
  }
  WriteBytes(path, text);
}

CalibrationHeader ReadCalibrationHeader(const std::filesystem::path& path) {
  const ConfigNode root = ConfigNode::Load(path);
  CalibrationHeader header = ReadHeader(root);
  if (!root.Has("images")) return header;
  const ConfigNode images = root.Map("images");
  for (const std::string& name : images.Keys()) {
    header.image_files.push_back(images.Map(name).Text("file"));
  }
  return header;
}

CalibrationData ReadCalibration(const std::filesystem::path& path,
                                const CalibrationDemand& demand) {
  const ConfigNode root = ConfigNode::Load(path);
  CalibrationHeader header = ReadHeader(root);
  root.Choice("kind", {demand.kind});
  CalibrationData data;
  data.kind = std::move(header.kind);
  data.created = header.created;
  data.format = std::move(header.format);
  data.temperature_c = header.temperature_c;
  data.light = std::move(header.light);
  CheckDemand(root, data, demand);
  const auto each = [&](const char* key, const auto& read) {
    if (!root.Has(key)) return;
    const ConfigNode node = root.Map(key);
    for (const std::string& name : node.Keys()) read(node, name);
  };
  each("texts", [&](const ConfigNode& n, const auto& name) { data.texts[name] = n.Text(name); });
  each("estimates", [&](const ConfigNode& n, const auto& name) {
    const auto pair = n.Numbers(name, 2);
    if (pair[1] < 0) n.Fail(name, "has a negative uncertainty");
    data.estimates[name] = {pair[0], pair[1]};
  });
  each("lists", [&](const ConfigNode& n, const auto& name) { data.lists[name] = n.Numbers(name); });
  each("images", [&](const ConfigNode& n, const auto& name) {
    data.images[name] = ReadSiteImage(n.Map(name), path.parent_path(), data.format);
  });
  root.RefuseUnknownKeys();
  return data;
}

}  // namespace gonio
