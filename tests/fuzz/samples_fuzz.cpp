// SPDX-License-Identifier: Apache-2.0
// Files with other people's samples: whatever is read is a reflectance, and the rest is refused.
// The first byte names the reader.
#include <cmath>

#include "brdf/cornell_brdf.h"
#include "brdf/rt300s_csv.h"
#include "brdf/samples_csv.h"
#include "core/check.h"
#include "core/error.h"
#include "tests/fuzz/scripted_link.h"

namespace gonio {
namespace {

std::vector<MeasuredSample> Read(char reader, const std::string& text) {
  try {
    if (reader == 'r') return ParseRt300s(text, "f").samples;
    if (reader == 'b') return ParseCornell(text, "f").samples;
    return ParseSamplesCsv(text, "f");
  } catch (const ConfigError& e) {
    GONIO_CHECK(std::string(e.what()).starts_with("f:"), "it does not name its file");
    return {};
  }
}

}  // namespace
}  // namespace gonio

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string bytes = gonio::TextOf(data, size);
  if (bytes.empty()) return 0;
  for (const gonio::MeasuredSample& m : gonio::Read(bytes[0], bytes.substr(1))) {
    const gonio::DirectionPair& pair = m.sample.directions;
    GONIO_CHECK(pair.above_horizon(), "a direction is below the horizon");
    GONIO_CHECK(std::abs(pair.wi.norm() - 1) + std::abs(pair.wo.norm() - 1) < 1e-9, "not unit");
    GONIO_CHECK(m.sample.f_r.isFinite().all() && std::isfinite(m.time_s), "not finite");
    GONIO_CHECK((m.sample.sigma > 0).all(), "no uncertainty");
  }
  return 0;
}
