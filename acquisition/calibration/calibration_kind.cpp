// SPDX-License-Identifier: Apache-2.0
#include "acquisition/calibration/calibration_kind.h"

#include <fmt/format.h>

#include "core/check.h"

namespace gonio {
namespace {

struct KindText {
  CalibrationKind kind;
  const char* name;
  const char* step;  // of gonio calibrate
};
constexpr KindText kTexts[] = {
    {CalibrationKind::kDark, "dark", "darks"},
    {CalibrationKind::kPhotonTransfer, "photon-transfer", "photon-transfer"},
    {CalibrationKind::kBadPixels, "bad-pixels", "darks"},
    {CalibrationKind::kFlatField, "flat-field", "flat"},
    {CalibrationKind::kStrayLight, "stray-light", "stray-light"},
    {CalibrationKind::kResponsivity, "responsivity", "standard"},
};

const KindText& TextOf(CalibrationKind kind) {
  for (const KindText& text : kTexts) {
    if (text.kind == kind) return text;
  }
  GONIO_CHECK(false, "every kind has its text");
  return kTexts[0];
}

}  // namespace

const char* ToString(CalibrationKind kind) { return TextOf(kind).name; }

std::string FileNameOf(CalibrationKind kind) { return fmt::format("{}.yaml", ToString(kind)); }

std::string CommandFor(CalibrationKind kind) {
  return fmt::format("gonio calibrate {}", TextOf(kind).step);
}

CalibrationPolicy ReadCalibrationPolicy(const ConfigNode& node) {
  CalibrationPolicy policy;
  const std::filesystem::path beside = std::filesystem::path(node.file()).parent_path();
  policy.folder = beside / node.Text("folder");
  policy.max_age = 86400 * node.NumberOr("max_age_days", policy.max_age / 86400, Range::Positive());
  policy.refuse_old =
      node.Has("when_old") && node.Choice("when_old", {"warn", "refuse"}) == "refuse";
  if (!node.Has("required")) return policy;
  for (const std::string& name : node.Texts("required")) {
    bool known = false;
    for (const KindText& text : kTexts) {
      if (name != text.name) continue;
      policy.required.push_back(text.kind);
      known = true;
    }
    if (!known) {
      node.Fail("required", fmt::format("'{}' is none of dark, photon-transfer, bad-pixels, "
                                        "flat-field, stray-light, responsivity",
                                        name));
    }
  }
  return policy;
}

}  // namespace gonio
