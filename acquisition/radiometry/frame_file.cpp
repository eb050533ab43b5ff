// SPDX-License-Identifier: Apache-2.0
#include "acquisition/radiometry/frame_file.h"

#include <fmt/format.h>

#include "acquisition/radiometry/tiff_image.h"
#include "core/config.h"
#include "core/error.h"
#include "core/file.h"
#include "core/sha256.h"

namespace gonio {
namespace {

constexpr const char* kFormat = "gonio-frame";

ImageSize SizeOf(const SensorFormat& format) {
  return {format.width, format.height, CountsPerPixel(format.layout)};
}

std::filesystem::path TiffOf(std::filesystem::path yaml) { return yaml.replace_extension("tiff"); }

std::string TextOf(const StoredFrame& stored, const std::string& digest) {
  const Frame& frame = stored.frame;
  std::string text = fmt::format(
      "format: {}\nversion: 1\nexposure_s: {}\ngain_db: {}\nblack_level: {}\nmonitor: {}\n"
      "start_s: {}\n",
      kFormat, frame.exposure.count(), frame.gain_db, frame.black_level, stored.monitor,
      frame.start.count());
  if (frame.temperature_c) text += fmt::format("temperature_c: {}\n", *frame.temperature_c);
  if (stored.colour) text += fmt::format("colour: {}\n", ToString(*stored.colour));
  return text + fmt::format("sha256: \"{}\"\n", digest);
}

}  // namespace

void WriteFrameFile(const std::filesystem::path& yaml, const SensorFormat& format,
                    const StoredFrame& stored) {
  const std::string bytes = EncodeTiff(yaml, SizeOf(format), stored.frame.counts);
  WriteFileAtomically(TiffOf(yaml), [&](std::ostream& out) { out << bytes; });
  const std::string text = TextOf(stored, Sha256(bytes));
  WriteFileAtomically(yaml, [&](std::ostream& out) { out << text; });
}

std::optional<StoredFrame> ReadFrameFile(const std::filesystem::path& yaml,
                                         const SensorFormat& format) {
  if (!std::filesystem::exists(yaml) || !std::filesystem::exists(TiffOf(yaml))) return std::nullopt;
  const ConfigNode root = ConfigNode::Load(yaml);
  root.Choice("format", {kFormat});
  root.Integer("version", 1, 1);
  StoredFrame stored;
  Frame& frame = stored.frame;
  frame.width = format.width;
  frame.height = format.height;
  frame.layout = format.layout;
  frame.exposure = Seconds(root.Number("exposure_s", Range::Positive()));
  frame.gain_db = root.Number("gain_db");
  frame.black_level = root.Number("black_level");
  frame.start = Seconds(root.Number("start_s"));
  if (root.Has("temperature_c")) frame.temperature_c = root.Number("temperature_c");
  stored.monitor = root.Number("monitor", Range::NonNegative());
  if (root.Has("colour")) {
    const std::string name = root.Choice("colour", {"red", "green", "blue"});
    for (const LightColour colour : kLightColours) {
      if (name == ToString(colour)) stored.colour = colour;
    }
  }
  const std::string digest = root.Text("sha256");
  root.RefuseUnknownKeys();
  const std::string bytes = ReadTextFile(TiffOf(yaml));
  if (Sha256(bytes) != digest) return std::nullopt;
  frame.counts = DecodeTiffCounts(TiffOf(yaml), SizeOf(format), bytes);
  return stored;
}

}  // namespace gonio
