// SPDX-License-Identifier: Apache-2.0
// gonio doctor: what stands between this machine and its devices, and what to do about it.

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "apps/gonio/build_rig.h"
#include "apps/gonio/camera_checks.h"
#include "apps/gonio/commands.h"
#include "apps/gonio/doctor_checks.h"
#include "apps/gonio/json_file.h"
#include "apps/gonio/locate.h"

namespace gonio {
namespace {

const char* NameOf(Finding::Kind kind) {
  switch (kind) {
    case Finding::Kind::kFine:
      return "fine";
    case Finding::Kind::kHint:
      return "hint";
    case Finding::Kind::kWrong:
      return "wrong";
  }
  return "";
}

void Append(std::vector<Finding>& all, std::vector<Finding> more) {
  all.insert(all.end(), more.begin(), more.end());
}

nlohmann::json ToJson(const std::vector<Finding>& findings) {
  nlohmann::json list = nlohmann::json::array();
  for (const Finding& finding : findings) {
    list.push_back(
        {{"kind", NameOf(finding.kind)}, {"subject", finding.subject}, {"what", finding.what}});
  }
  return {{"findings", list}};
}

}  // namespace

int DoctorCommand(const DoctorOptions& options) {
  std::vector<Finding> findings = CheckSerialPorts();
  Append(findings, CheckUsbInstruments());
  Append(findings, CheckUsbCameras());
  if (!options.rig.empty()) {
    const RigConfig rig = LoadRig(LocateConfig(options.rig)).config;
    Append(findings, CheckPortsOf(rig));
    Append(findings, CheckCameraOf(rig));
  }
  if (options.json != "-") {
    for (const Finding& finding : findings) {
      fmt::print("{:5}  {}: {}\n", NameOf(finding.kind), finding.subject, finding.what);
    }
  }
  if (!options.json.empty()) WriteJson(options.json, ToJson(findings));
  const bool wrong = std::any_of(findings.begin(), findings.end(), [](const Finding& finding) {
    return finding.kind == Finding::Kind::kWrong;
  });
  return wrong ? kFailed : kDone;
}

}  // namespace gonio
