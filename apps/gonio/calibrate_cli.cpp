// SPDX-License-Identifier: Apache-2.0
#include "apps/gonio/calibrate_cli.h"

#include <CLI/CLI.hpp>
#include <memory>

#include "apps/gonio/commands.h"

namespace gonio {
namespace {

struct StepHelp {
  const char* name;
  const char* help;
};
constexpr StepHelp kSteps[] = {
    {"darks", "Frames without light: dark.yaml, bad-pixels.yaml"},
    {"photon-transfer",
     "Gain, read noise, full well, linearity, from a white tile at many "
     "exposures: photon-transfer.yaml"},
    {"flat", "The sensor's pattern, from a white tile: flat-field.yaml"},
    {"stray-light",
     "Light that does not come from the sample, from a black trap: "
     "stray-light.yaml"},
    {"glare",
     "Veiling glare of the lens, from a black trap in a white tile that fills the image: "
     "stray-light.yaml"},
    {"standard", "Responsivity, from a reference standard: responsivity.yaml"},
};

void AddRig(CLI::App& app, CalibrateOptions& o) {
  app.add_option("--rig", o.rig, "Rig file")->capture_default_str();
  app.add_option("--out", o.out, "Folder of the files (default: the rig's calibration.folder)");
}

void AddStep(CLI::App& app, CalibrateOptions& o, const std::string& step) {
  AddRig(app, o);
  app.add_option("--material", o.material,
                 "What a simulated camera has before it (default: ptfe.yaml; for stray-light "
                 "trap.yaml)");
  if (step == "glare") {
    app.add_option("--trap-radius-mm", o.trap_radius_mm,
                   "Of the trap in the middle (default: the rig's imaging.patch_radius_mm)")
        ->check(CLI::PositiveNumber);
  }
  if (step == "standard") {
    app.add_option("--standard", o.standard, "The standard's file, with its certificate's table")
        ->required();
  }
  if (step != "darks") {
    app.add_option("--theta-i-deg", o.theta_i_deg, "Of the light, from the normal")
        ->check(CLI::Range(0.0, 89.0));
    app.add_option("--theta-o-deg", o.theta_o_deg,
                   "Of the camera; positive on the side of the mirror direction")
        ->check(CLI::Range(-89.0, 89.0));
  }
  app.add_option("--frames", o.frames, "Of each exposure (default: the step's own)")
      ->check(CLI::Range(2, 10000));
  app.add_flag("--again", o.again, "Begin anew, without the frames of a start that was stopped");
  app.add_flag("--keep-frames", o.keep_frames, "Leave the raw frames when the step is done");
  app.add_option("--seed", o.seed, "Of the simulated noise")->capture_default_str();
  app.add_flag("--quiet", o.quiet, "No progress, only the results");
}

std::function<int()> SetUpCalibrateGeometry(CLI::App& app) {
  auto o = std::make_shared<CalibrateGeometryOptions>();
  app.add_option("--rig", o->rig, "Rig file; its camera must read out enough to show the target")
      ->required();
  app.add_option("--out", o->out, "Calibration folder; views already there are kept")->required();
  app.add_option("--target", o->target,
                 "What is on the stage: board finds the camera, mirror then the light; none: fit "
                 "the views in the folder again")
      ->check(CLI::IsMember({"board", "mirror", "none"}))
      ->capture_default_str();
  app.add_option("--columns", o->columns, "Inner corners of the board along x")
      ->check(CLI::Range(3, 100))
      ->capture_default_str();
  app.add_option("--rows", o->rows, "Inner corners along y")
      ->check(CLI::Range(3, 100))
      ->capture_default_str();
  app.add_option("--square-mm", o->square_mm, "Side of a square")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  app.add_option("--seed", o->seed, "Of the simulated noise")->capture_default_str();
  app.add_flag("--quiet", o->quiet, "No progress, only the result");
  return [o] { return CalibrateGeometryCommand(*o); };
}

std::function<int()> SetUpCalibrateTime(CLI::App& app) {
  auto o = std::make_shared<CalibrateTimeOptions>();
  app.add_option("sessions", o->sessions, "Session directories of one rig")->required();
  app.add_option("--out", o->out, "File to write: time.yaml in the calibration folder")->required();
  return [o] { return CalibrateTimeCommand(*o); };
}

}  // namespace

std::function<int()> SetUpCalibrate(CLI::App& app) {
  auto o = std::make_shared<CalibrateOptions>();
  app.require_subcommand(1);
  for (const StepHelp& step : kSteps) {
    CLI::App* sub = app.add_subcommand(step.name, step.help);
    AddStep(*sub, *o, step.name);
    sub->callback([o, name = std::string(step.name)] { o->step = name; });
  }
  CLI::App* status = app.add_subcommand("status", "What there is, how old, for which camera");
  AddRig(*status, *o);
  status->callback([o] { o->step = "status"; });
  auto action = std::make_shared<std::function<int()>>();
  CLI::App* geometry = app.add_subcommand(
      "geometry",
      "Lens, distances and the arms' offsets, from a board and a mirror: geometry.yaml");
  geometry->callback([action, run = SetUpCalibrateGeometry(*geometry)] { *action = run; });
  CLI::App* time =
      app.add_subcommand("time", "Speeds and overheads, from sessions that were run: time.yaml");
  time->callback([action, run = SetUpCalibrateTime(*time)] { *action = run; });
  return [o, action] {
    if (*action) return (*action)();
    return o->step == "status" ? CalibrateStatusCommand(*o) : CalibrateCommand(*o);
  };
}

}  // namespace gonio
