// SPDX-License-Identifier: Apache-2.0
#include "acquisition/session_frames.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <string>

#include "acquisition/event_log.h"
#include "acquisition/event_log_sqlite.h"
#include "acquisition/light_colours.h"
#include "acquisition/session_record.h"

namespace gonio {
namespace {

PixelLayout LayoutOf(const std::string& name) {
  const auto* const found =
      std::find_if(std::begin(kPixelLayouts), std::end(kPixelLayouts),
                   [&](PixelLayout layout) { return name == ToString(layout); });
  if (found == std::end(kPixelLayouts)) throw ConfigError("there is no pixel layout " + name);
  return *found;
}

// The first format knows only cameras whose pixels have three counts, and says no more of them; the
// first three know white light only.
const char* Select(std::int64_t version) {
  if (version >= 4) {
    return "SELECT exposure_s, black_level, monitor, start_s, saturated_red, saturated_green, "
           "saturated_blue, width, height, counts, gain_db, temperature_c, layout, colour FROM "
           "exposures WHERE pose = ? ORDER BY frame";
  }
  return version >= 2
             ? "SELECT exposure_s, black_level, monitor, start_s, saturated_red, "
               "saturated_green, saturated_blue, width, height, counts, gain_db, "
               "temperature_c, layout, NULL FROM exposures WHERE pose = ? ORDER BY frame"
             : "SELECT exposure_s, black_level, monitor, start_s, saturated_red, "
               "saturated_green, saturated_blue, width, height, counts, 0.0, NULL, 'rgb', NULL "
               "FROM exposures WHERE pose = ? ORDER BY frame";
}

}  // namespace

struct SessionFrames::Impl {
  explicit Impl(const std::filesystem::path& dir) : db(dir / kSessionFile, SQLITE_OPEN_READONLY) {}
  sqlite::Database db;
  std::int64_t version = 0;
};

SessionFrames::SessionFrames(const std::filesystem::path& dir) {
  CheckSession(dir);
  try {
    impl_ = std::make_unique<Impl>(dir);
    sqlite::Statement version(impl_->db, "PRAGMA user_version");
    if (version.Step()) impl_->version = version.Integer(0);
  } catch (const sqlite::Failure& e) {
    throw ConfigError(e.what());
  }
}

SessionFrames::~SessionFrames() = default;

std::vector<Exposure> SessionFrames::Of(int pose) {
  std::vector<Exposure> exposures;
  try {
    sqlite::Statement row(impl_->db, Select(impl_->version));
    row.Bind(pose);
    while (row.Step()) {
      Exposure& exposure = exposures.emplace_back();
      Frame& frame = exposure.frame;
      frame.exposure = Seconds(row.Real(0));
      frame.black_level = row.Real(1);
      exposure.monitor = row.Real(2);
      frame.start = Seconds(row.Real(3));
      for (int c = 0; c < kChannels; ++c) exposure.saturated[c] = row.Integer(4 + c) != 0;
      frame.width = static_cast<int>(row.Integer(7));
      frame.height = static_cast<int>(row.Integer(8));
      const std::span<const std::uint8_t> bytes = row.Bytes(9);
      frame.gain_db = row.Real(10);
      if (!row.IsNull(11)) frame.temperature_c = row.Real(11);
      frame.layout = LayoutOf(row.Text(12));
      if (!row.IsNull(13)) exposure.colour = ColourNamed(row.Text(13));
      const auto counts =
          static_cast<std::size_t>(frame.width) * frame.height * CountsPerPixel(frame.layout);
      if (bytes.size() != 2 * counts) {
        throw ConfigError(fmt::format("{}: pose {}: frame {} has {} bytes, not {}",
                                      impl_->db.file().string(), pose, exposures.size(),
                                      bytes.size(), 2 * counts));
      }
      frame.counts.resize(counts);
      for (std::size_t i = 0; i < counts; ++i) {
        frame.counts[i] = static_cast<std::uint16_t>(bytes[2 * i] | bytes[2 * i + 1] << 8);
      }
    }
  } catch (const sqlite::Failure& e) {
    throw ConfigError(e.what());
  }
  return exposures;
}

}  // namespace gonio
