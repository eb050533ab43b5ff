// SPDX-License-Identifier: Apache-2.0
// gonio calibrate time: how fast the axes of the sessions' rig really were.

#include <fmt/format.h>

#include <ctime>
#include <stdexcept>

#include "acquisition/session_record.h"
#include "acquisition/time_model/time_model.h"
#include "apps/gonio/commands.h"
#include "core/config.h"
#include "core/units.h"

namespace gonio {
namespace {

void Print(const TimeFit& fit, std::span<const char* const> axes) {
  fmt::print("{:17} {:>18} {:>20} {:>18} {}\n", "axis", "speed, deg/s", "acc., deg/s2",
             "overhead, s", "decided");
  for (std::size_t i = 0; i < axes.size(); ++i) {
    const auto cell = [](const MeasuredValue& e, double unit) {
      return fmt::format("{:.3f} +- {:.3f}", e.value / unit, e.sigma / unit);
    };
    const double degree = RadFromDeg(1);
    fmt::print("{:17} {:>18} {:>20} {:>18} {:>7}\n", axes[i], cell(fit.max_speed[i], degree),
               cell(fit.acceleration[i], degree), cell(fit.move_overhead[i], 1), fit.decided[i]);
  }
  fmt::print("each pose  {:.3f} +- {:.3f} s, each frame {:.3f} +- {:.3f} s\n",
             fit.pose_overhead.value, fit.pose_overhead.sigma, fit.frame_overhead.value,
             fit.frame_overhead.sigma);
  fmt::print(
      "error of a move's predicted time, rms of {}: {:.3f} s by the rig file, {:.3f} s now\n",
      fit.moves, fit.believed_rms, fit.fitted_rms);
}

}  // namespace

int CalibrateTimeCommand(const CalibrateTimeOptions& options) {
  LoggedTimes times;
  RigConfig rig;
  for (const auto& dir : options.sessions) {
    const SessionRecord session = ReadSession(dir);
    const RigConfig its =
        ReadRig(ConfigNode::Parse(session.info.rig_text, dir.string()), session.info.rig_text);
    if (!rig.name.empty() && its.name != rig.name) {
      throw ConfigError(
          fmt::format("{}: was measured on {}, others on {}", dir.string(), its.name, rig.name));
    }
    rig = its;
    AddTimes(session, rig, times);
  }
  const auto fit = FitTimes(rig, times);
  if (!fit) throw ConfigError(fit.error().message);
  Print(*fit, rig.axis_names());
  if (!options.out.parent_path().empty()) {
    std::filesystem::create_directories(options.out.parent_path());
  }
  WriteTimes(options.out, *fit, rig.axis_names(), std::time(nullptr));
  fmt::print("wrote {}\n", options.out.string());
  return kDone;
}

}  // namespace gonio
