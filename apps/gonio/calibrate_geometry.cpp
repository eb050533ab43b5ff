// SPDX-License-Identifier: Apache-2.0
// gonio calibrate geometry: images of a board, then of a mirror; a fit to both.

#include <fmt/format.h>

#include <ctime>

#include "acquisition/geometry_calibration/geometry_file.h"
#include "acquisition/geometry_calibration/target_session.h"
#include "apps/gonio/build_rig.h"
#include "apps/gonio/commands.h"
#include "apps/gonio/device_error.h"
#include "apps/gonio/interrupt.h"
#include "apps/gonio/locate.h"
#include "brdf/analytic.h"
#include "core/config.h"
#include "core/units.h"

namespace gonio {
namespace {

namespace fs = std::filesystem;

// Smaller images show no board (find_target.h).
constexpr int kLeastSide = 200;

void CheckRig(const RigConfig& rig, const CalibrateGeometryOptions& options) {
  if (rig.geometry.kind != RigKind::kFourAxisArms) {
    ConfigNode::Parse(rig.text, options.rig)
        .Map("geometry")
        .Fail("kind", fmt::format("is {}: only the geometry of four-axis-arms can be calibrated",
                                  ToString(rig.geometry.kind)));
  }
  if (!rig.imaging.resolves_directions()) {
    throw ConfigError(options.rig + ": imaging: is needed to calibrate the geometry");
  }
  if (std::min(rig.camera.width, rig.camera.height) < kLeastSide) {
    throw ConfigError(fmt::format(
        "{}: camera: reads out {} by {} pixels; the corners of a board need at least {} each way: "
        "let the rig file read out more of the sensor, for this and for the sessions that use it",
        options.rig, rig.camera.width, rig.camera.height, kLeastSide));
  }
  if (options.columns == options.rows) {
    throw ConfigError("--columns and --rows must differ: a quarter turn could not be told");
  }
}

void MountTarget(const CalibrateGeometryOptions& options, SimTarget& target) {
  target.kind =
      options.target == "board" ? SimTarget::Kind::kCheckerboard : SimTarget::Kind::kMirror;
  target.columns = options.columns;
  target.rows = options.rows;
  target.square = options.square_mm / 1000;
}

[[noreturn]] void Fail(const Error& error) {
  if (error.code == ErrorCode::kRefused) throw std::runtime_error(error.message);
  throw std::runtime_error("stopped: " + error.message);
}

void Photograph(RigFile& file, const CalibrateGeometryOptions& options, TargetViews& views) {
  MountTarget(options, file.simulation.target);
  const AnalyticBrdf nothing("target", {Lambert{}});
  OpenedRig rig = file.config.simulated
                      ? OpenSimulated(file, nothing, options.seed)
                      : OpenReal(file, &nothing, options.seed, std::make_unique<SystemClock>());
  views.camera = rig.devices.camera->identity();
  const Interrupt interrupt;
  const TargetSession session{file.config, rig.devices, *rig.clock, interrupt.after_pose(),
                              [&](int pose, int count, const std::string& note) {
                                if (!options.quiet)
                                  fmt::print("{:3} of {}: {}\n", pose, count, note);
                              }};
  if (options.target == "board") {
    auto seen = PhotographBoard(session, views.board);
    if (!seen) Fail(seen.error());
    views.boards = std::move(seen).value();
  } else {
    auto seen = PhotographMirror(session);
    if (!seen) Fail(seen.error());
    views.mirrors = std::move(seen).value();
  }
}

void Print(const GeometryFit& fit) {
  const auto angle = [&](const char* name, GeometryUnknown i) {
    fmt::print("{:26} {:10.4f} +- {:.4f} deg\n", name, DegFromRad(fit[i]),
               DegFromRad(fit.unknowns[i].sigma));
  };
  const auto number = [&](const char* name, GeometryUnknown i, double unit, const char* of) {
    fmt::print("{:26} {:10.4f} +- {:.4f} {}\n", name, fit[i] / unit, fit.unknowns[i].sigma / unit,
               of);
  };
  fmt::print("board    {} views, {:.3f} px rms\n", fit.board_views, fit.board_rms);
  if (fit.has_light)
    fmt::print("mirror   {} views, {:.3f} px rms\n", fit.mirror_views, fit.mirror_rms);
  for (const std::string& view : fit.left_out) fmt::print("left out {}\n", view);
  number("focal length", kFocalLength, 1, "px");
  number("principal point x", kPrincipalX, 1, "px");
  number("principal point y", kPrincipalY, 1, "px");
  if (fit.distorted) number("radial distortion", kRadialDistortion, 1, "");
  angle("camera turn, right", kCameraTurnX);
  angle("camera turn, down", kCameraTurnY);
  angle("camera turn, forward", kCameraTurnZ);
  number("camera distance", kCameraDistance, 1e-3, "mm");
  angle("camera azimuth offset", kCameraAzimuthOffset);
  angle("camera elevation offset", kCameraElevationOffset);
  if (!fit.has_light) return;
  number("light distance", kLightDistance, 1e-3, "mm");
  angle("light azimuth offset", kLightAzimuthOffset);
  angle("light elevation offset", kLightElevationOffset);
  fmt::print("{:26} {:.5f} deg\n", "sigma of directions", DegFromRad(fit.SigmaOfDirections({})));
}

}  // namespace

int CalibrateGeometryCommand(const CalibrateGeometryOptions& options) {
  RigFile file = LoadRig(LocateConfig(options.rig), CalibrationUse::kIgnored);
  CheckRig(file.config, options);
  fs::create_directories(options.out);
  const fs::path views_path = options.out / kViewsFile;
  TargetViews views;
  if (fs::exists(views_path)) views = ReadViews(views_path);
  if (options.target != "none") {
    if (options.target == "board") {
      views.board = {options.columns, options.rows, options.square_mm / 1000};
    }
    Photograph(file, options, views);
    WriteViews(views_path, views);
  }
  if (views.boards.empty()) {
    fmt::print("wrote {}; the fit needs the board, too: --target board\n", views_path.string());
    return kDone;
  }
  const GeometryBelief belief{file.built, file.config.camera.width, file.config.camera.height};
  auto fit = FitGeometry(belief, views.board, views.boards, views.mirrors);
  if (!fit) Fail(fit.error());
  Print(*fit);
  const fs::path path = options.out / kGeometryFile;
  WriteGeometry(path, *fit, SensorFormatOf(file.config, views.camera), std::time(nullptr));
  fmt::print("wrote {}\n", path.string());
  return kDone;
}

}  // namespace gonio
