// SPDX-License-Identifier: Apache-2.0
#include "apps/gonio/cli.h"

#include <CLI/CLI.hpp>
#include <functional>
#include <memory>

#include "apps/gonio/calibrate_cli.h"
#include "apps/gonio/commands.h"
#include "apps/gonio/import.h"
#include "core/error.h"

namespace gonio {
namespace {

using Action = std::function<int()>;

constexpr const char* kPrior = "\"none\", \"generic\" or a prior file";

Action SetUpRun(CLI::App& app) {
  auto o = std::make_shared<RunOptions>();
  app.add_option("--rig", o->rig, "Rig file")->capture_default_str();
  app.add_option("--plan", o->plan, "Plan file")->capture_default_str();
  app.add_option(
      "--material", o->material,
      "What a simulated camera sees: a MERL .binary, RGL .bsdf or material .yaml; with a "
      "real camera, something to compare with");
  CLI::Option* const out =
      app.add_option("--out", o->out, "Directory to make for the session; must not exist");
  app.add_option("--max-poses", o->max_poses, "Budget of poses (default: the plan's)")
      ->check(CLI::PositiveNumber);
  app.add_option("--seed", o->seed, "Of the planner and of the simulated noise")
      ->capture_default_str();
  app.add_option("--prior", o->prior, std::string(kPrior) + " (default: the plan's)");
  app.add_option("--calibration", o->calibration,
                 "Folder of calibration files (default: the rig's calibration.folder)");
  app.add_flag("--quiet", o->quiet, "No progress, only the summary");
  app.add_option(
      "--notify", o->notify,
      "Command to run at a failure, a suspension, a pause and the end, with what happened "
      "as JSON on its standard input");
  app.add_flag("--park", o->park, "Leave the arms at the rig's motion.park_deg after a clean end");
  CLI::Option* const resume =
      app.add_option("--resume", o->resume, "Go on with this session; everything else is its own")
          ->excludes(out);
  for (const char* own : {"--rig", "--plan", "--material", "--seed", "--prior", "--calibration"}) {
    resume->excludes(app.get_option(own));
  }
  app.add_flag("--accept-changed", o->accept_changed,
               "Go on although files, devices or decisions are not as they were")
      ->needs(resume);
  app.add_option("--max-reference-change-percent", o->max_reference_change_percent,
                 "Of the last pose, measured again after a resume; more ends the session")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  return [o] { return RunCommand(*o); };
}

Action SetUpFit(CLI::App& app) {
  auto o = std::make_shared<FitCommandOptions>();
  app.add_option("input", o->input,
                 "A MERL .binary, RGL .bsdf, material .yaml, samples .csv, or a session directory")
      ->required();
  app.add_option("--out", o->out, "Fit file to write (.yaml)")->required();
  app.add_option("--method", o->method,
                 "em: slice by slice as published; joint: all lobes of a slice together; "
                 "continuous: splines over theta_d with a prior")
      ->check(CLI::IsMember({"em", "joint", "continuous"}))
      ->capture_default_str();
  app.add_option("--lobes", o->lobes,
                 "Lobes per channel; auto: as many as BIC likes (default: the prior's, or 3)")
      ->check(CLI::IsMember({"1", "2", "3", "4", "5", "auto"}));
  app.add_option("--keep-every", o->keep_every, "Keep every n-th theta_h only")
      ->check(CLI::Range(1, 90))
      ->capture_default_str();
  app.add_option("--slice-step-deg", o->slice_step_deg,
                 "theta_d between the slices of em and joint")
      ->check(CLI::Range(1.0, 30.0))
      ->capture_default_str();
  app.add_option("--prior", o->prior, std::string(kPrior) + ", for continuous")
      ->capture_default_str();
  return [o] { return FitCommand(*o); };
}

Action SetUpExport(CLI::App& app) {
  auto o = std::make_shared<ExportOptions>();
  app.add_option("input", o->input,
                 "A session directory; to merl also a fit .yaml, .bsdf or material .yaml")
      ->required();
  app.add_option("--to", o->format,
                 "merl: the full table (of a session, from its fit); csv: a session's samples")
      ->check(CLI::IsMember({"merl", "csv"}));
  app.add_option("output", o->out, "File to write, for --to");
  app.add_option("--frames", o->frames,
                 "Folder to make for a session's raw frames: a .tiff each with its .yaml");
  return [o] { return ExportCommand(*o); };
}

Action SetUpImport(CLI::App& app) {
  auto o = std::make_shared<ImportOptions>();
  app.add_option("file", o->file, "Samples .csv, RT-300S .csv or Cornell .brdf")->required();
  app.add_option("--out", o->out, "Session directory to make; must not exist")->required();
  app.add_option("--format", o->format, "auto: by the file's name and header")
      ->check(CLI::IsMember({"auto", "csv", "rt300s", "cornell"}))
      ->capture_default_str();
  app.add_option("--bands-nm", o->bands_nm,
                 "cornell: wavelengths that make red, green and blue (default: "
                 "600-700,500-590,440-490)");
  app.add_option("--min-separation-deg", o->min_separation_deg,
                 "Samples with light and detector nearer to each other are not fitted: one is in "
                 "the other's light (default: rt300s 5.5, others 0)")
      ->check(CLI::Range(0.0, 180.0));
  app.add_option("--prior", o->prior, std::string(kPrior) + ", for its fit")->capture_default_str();
  return [o] { return ImportCommand(*o); };
}

Action SetUpCompare(CLI::App& app) {
  auto o = std::make_shared<CompareOptions>();
  constexpr const char* kKinds = ": .binary, .bsdf, material .yaml, fit .yaml or session";
  app.add_option("reference", o->reference,
                 std::string("The truth") + kKinds + "; or samples .csv, to compare there only")
      ->required();
  app.add_option("other", o->other, std::string("What is judged") + kKinds)->required();
  app.add_option("--json", o->json, "Write the metrics to this file, too (\"-\": standard output)");
  app.add_option("--max-theta-deg", o->max_theta_deg, "Leave out directions nearer the horizon")
      ->check(CLI::Range(1.0, 90.0))
      ->capture_default_str();
  app.add_option("--phi-stride", o->phi_stride, "Look at every n-th phi_d cell only")
      ->check(CLI::Range(1, 180))
      ->capture_default_str();
  app.add_flag("!--no-render", o->render, "Do not render spheres and compare these");
  return [o] { return CompareCommand(*o); };
}

Action SetUpStudy(CLI::App& app) {
  auto o = std::make_shared<StudyOptions>();
  app.add_option("study", o->study, "Study file, e.g. study-thinning.yaml, study-frontier.yaml")
      ->required();
  app.add_option("--materials", o->materials,
                 "Folders in which the study's materials are (default: the study file's own)");
  app.add_option("--out", o->out, "Folder for the results; a study begun there is continued")
      ->required();
  app.add_option("--threads", o->threads, "Cells at a time (default: every core)")
      ->check(CLI::PositiveNumber);
  app.add_flag("--quiet", o->quiet, "No progress, only the summary");
  return [o] { return StudyCommand(*o); };
}

Action SetUpPlot(CLI::App& app) {
  auto o = std::make_shared<PlotOptions>();
  app.add_option("input", o->input, "A fit file, a session directory or a study's folder")
      ->required();
  app.add_option("--out", o->out, "Picture to write: .png or .svg")->required();
  app.add_option("--kind", o->kind,
                 "slice: data, lobes and their sum at one theta_d; error-map: where the error is; "
                 "density: a study's error against density (default: what suits the input)")
      ->check(CLI::IsMember({"slice", "error-map", "density"}));
  app.add_option("--reference", o->reference, "What was fitted; needed for an error map");
  app.add_option("--theta-d-deg", o->theta_d_deg, "Of the slice")
      ->check(CLI::Range(0.0, 90.0))
      ->capture_default_str();
  app.add_option("--colour", o->colour, "Of the slice or the error map")
      ->check(CLI::IsMember({"red", "green", "blue"}))
      ->capture_default_str();
  app.add_option("--keep-every", o->keep_every, "Show every n-th theta_h of the data only")
      ->check(CLI::Range(1, 90))
      ->capture_default_str();
  app.add_option("--method", o->method, "Of a study with several (default: one panel for each)")
      ->check(CLI::IsMember({"em", "joint", "continuous"}));
  return [o] { return PlotCommand(*o); };
}

Action SetUpRender(CLI::App& app) {
  auto o = std::make_shared<RenderCommandOptions>();
  app.add_option("inputs", o->inputs, "Reflectances of any kind; several are shown side by side")
      ->required();
  app.add_option("--out", o->outs,
                 "Image to write: .png (tone-mapped), .hdr or .exr (linear); can be repeated")
      ->required();
  app.add_option("--light", o->light, "point: one distant light; env: light from all around")
      ->check(CLI::IsMember({"point", "env"}))
      ->capture_default_str();
  app.add_option("--environment", o->environment,
                 "Equirectangular .hdr or .exr for --light env (default: a built-in sky)");
  app.add_option("--size", o->size, "Of each sphere's image, in pixels")
      ->check(CLI::Range(16, 4096))
      ->capture_default_str();
  app.add_option("--samples", o->samples, "Directions of light per pixel, for --light env")
      ->check(CLI::Range(1, 65536))
      ->capture_default_str();
  app.add_option("--exposure", o->exposure,
                 "Factor on the linear values before they are shown; auto: the first input's")
      ->capture_default_str();
  return [o] { return RenderCommand(*o); };
}

Action SetUpSimulate(CLI::App& app) {
  auto o = std::make_shared<SimulateOptions>();
  app.add_option("--rig", o->rig, "Rig file; must be simulated")->capture_default_str();
  app.add_option("--plan", o->plans, "Plan files")->required();
  app.add_option("materials,--material", o->materials,
                 "Materials: MERL .binary, RGL .bsdf or material .yaml (default: drawn from a "
                 "learned prior)");
  app.add_option("--target", o->target,
                 "An error (MALE): how many poses and hours until it is reached?")
      ->check(CLI::PositiveNumber);
  app.add_option("--draws", o->draws, "So many materials from the prior where none is named")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  app.add_option("--prior", o->prior, std::string(kPrior) + " (default: each plan's)");
  app.add_option("--max-poses", o->max_poses, "Budget of poses (default: each plan's)")
      ->check(CLI::PositiveNumber);
  app.add_option("--seed", o->seed, "The first seed")->capture_default_str();
  app.add_option("--seeds", o->seeds, "Repeat with so many seeds; the table shows means")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  app.add_option("--threads", o->threads, "Sessions at a time (default: every core)")
      ->check(CLI::PositiveNumber);
  app.add_option("--json", o->json,
                 "Write every session's numbers to this file, too (\"-\": standard output)");
  app.add_flag("--quiet", o->quiet, "No progress, only the table");
  return [o] { return SimulateCommand(*o); };
}

Action SetUpRescue(CLI::App& app) {
  auto o = std::make_shared<RescueOptions>();
  app.add_option("session", o->session, "A session directory")->required();
  app.add_option("--out", o->out,
                 "Directory to make of what is whole (default: only look for damage)");
  return [o] { return RescueCommand(*o); };
}

Action SetUpReplay(CLI::App& app) {
  auto o = std::make_shared<ReplayOptions>();
  app.add_option("session", o->session, "A session directory")->required();
  app.add_flag("--rereduce", o->rereduce, "Make its samples anew from its raw frames");
  app.add_option("--calibration", o->calibration,
                 "The same with calibration files of this folder in place of the session's")
      ->check(CLI::ExistingDirectory);
  app.add_flag("--refit", o->refit, "Fit its samples again, the new ones if there are any");
  app.add_option("--plan", o->plan,
                 "What this plan would have chosen: where the session has no reading, its estimate "
                 "stands in");
  app.add_option("--rig", o->rig, "Rig file for --plan where the session was imported");
  app.add_option("--out", o->out, "Folder to make for samples, fit and choices");
  app.add_option("--speed", o->speed, "Show the turns, so many times as fast as they were")
      ->check(CLI::PositiveNumber);
  app.add_option("--json", o->json, "Write the numbers to this file, too (\"-\": standard output)");
  return [o] { return ReplayCommand(*o); };
}

Action SetUpReport(CLI::App& app) {
  auto o = std::make_shared<ReportOptions>();
  app.add_option("session", o->session, "A session directory")->required();
  app.add_option("--out", o->out, "Page to write (default: report.html in the session)");
  return [o] { return ReportCommand(*o); };
}

Action SetUpPrior(CLI::App& app) {
  auto o = std::make_shared<PriorLearnOptions>();
  app.require_subcommand(1);
  CLI::App* learn = app.add_subcommand(
      "learn", "What materials have in common, to measure others of their kind with fewer poses");
  learn->add_option("materials", o->materials, "Materials: .binary, .bsdf, .yaml or sessions")
      ->required();
  learn->add_option("--out", o->out, "Prior file to write, for --prior")->required();
  return [o] { return PriorLearnCommand(*o); };
}

Action SetUpDevices(CLI::App& app) {
  auto o = std::make_shared<DevicesOptions>();
  app.add_option("--gige-address", o->gige_addresses, "Ask the GigE Vision camera there, too");
  app.add_flag("--gige", o->gige,
               "Search for GigE Vision cameras, too: a broadcast on every network interface");
  app.add_option("--json", o->json, "Write the same as JSON (-: to standard output)");
  return [o] { return DevicesCommand(*o); };
}

Action SetUpSimDevices(CLI::App& app) {
  auto o = std::make_shared<SimDevicesOptions>();
  app.add_option("--rig", o->rig, "Rig file of kind real whose devices to stand in for")
      ->capture_default_str();
  app.add_option("--speed", o->speed, "How many times as fast as real ones the doubles move")
      ->check(CLI::PositiveNumber)
      ->capture_default_str();
  app.add_option(
      "--material", o->material,
      "What a double of the rig's camera sees: MERL .binary, RGL .bsdf or material .yaml");
  constexpr const char* kDouble = "Double of the camera";
  app.add_option("--packet-loss-percent", o->packet_loss_percent,
                 "Packets of images that never arrive")
      ->check(CLI::Range(0.0, 100.0))
      ->group(kDouble);
  app.add_option("--camera-late-frames", o->camera_late_frames,
                 "Frames after a change of the exposure time that still have the one before")
      ->check(CLI::Range(0, 10))
      ->group(kDouble);
  app.add_flag("--camera-chunk-data", o->camera_chunk_data,
               "Its frames say how they were taken, as chunk data")
      ->group(kDouble);
  app.add_option("--camera-gone-after", o->camera_gone_after,
                 "Exposures after which it is unplugged (default: never)")
      ->check(CLI::PositiveNumber)
      ->group(kDouble);
  app.add_option("--camera-gone-for-s", o->camera_gone_for_s,
                 "Until it is plugged in again (default: for good)")
      ->check(CLI::PositiveNumber)
      ->group(kDouble);
  app.add_option("--frames-log", o->frames_log, "SHA-256 of every frame's counts as it was sent")
      ->group(kDouble);
  app.add_option("command", o->command,
                 "-- COMMAND ...: started so that it sees them, and nothing else; without it, your "
                 "shell");
  app.positionals_at_end();
  return [o] { return SimDevicesCommand(*o); };
}

Action SetUpDoctor(CLI::App& app) {
  auto o = std::make_shared<DoctorOptions>();
  app.add_option("--rig", o->rig,
                 "Rig file whose ports are opened and closed again (boards that reset when their "
                 "port is opened do), and whose camera the system must be ready for");
  app.add_option("--json", o->json, "Write the same as JSON (-: to standard output)");
  return [o] { return DoctorCommand(*o); };
}

Action SetUpCheck(CLI::App& app) {
  auto o = std::make_shared<CheckOptions>();
  app.add_option("rig", o->rig, "Rig file")->required();
  app.add_option("--out", o->out, "Picture of the poses to write: .png or .svg (needs gnuplot)");
  app.add_option("--json", o->json, "Write the counts as JSON (-: to standard output)");
  return [o] { return CheckCommand(*o); };
}

struct Command {
  const char* name;
  const char* help;
  Action (*set_up)(CLI::App&);
};

constexpr Command kCommands[] = {
    {"run", "Measure a sample: run a session and fit it", SetUpRun},
    {"calibrate", "One step of calibrating the camera and the instrument, or what there is of it",
     SetUpCalibrate},
    {"fit", "Fit a table, samples or a session again", SetUpFit},
    {"export", "Write a session, fit or material in other people's formats", SetUpExport},
    {"import", "Make a session of what another instrument has measured", SetUpImport},
    {"compare", "How far one reflectance is from another", SetUpCompare},
    {"prior", "Learn a prior from materials that were measured densely", SetUpPrior},
    {"simulate", "What plans would cost and bring on a rig; keeps no session", SetUpSimulate},
    {"study",
     "Fit many materials in many ways, or let planners compete; continues where it stopped",
     SetUpStudy},
    {"plot", "Draw a fit's slices, its errors, or a study (needs gnuplot)", SetUpPlot},
    {"render", "Render spheres of reflectances", SetUpRender},
    {"devices", "List what is plugged in: serial ports, and which USB adapter is behind which",
     SetUpDevices},
    {"sim-devices", "Start doubles of a rig's devices, for the real drivers to be tried on",
     SetUpSimDevices},
    {"check", "Which poses a rig can measure, and what keeps it from the others", SetUpCheck},
    {"doctor", "What keeps this machine from its devices, and what to do about it", SetUpDoctor},
    {"replay", "Make a session's decisions once more from its log, and samples and fit if asked",
     SetUpReplay},
    {"rescue", "Look for damage in a session, and keep what is whole", SetUpRescue},
    {"report", "Show a session as one HTML page with pictures (needs gnuplot)", SetUpReport},
};

constexpr const char* kFooter =
    "Rig, plan and material files without a folder are also looked for among the configurations\n"
    "that gonio comes with (GONIO_CONFIG_DIR names another place).\n\n"
    "Exit codes: 0 done, 1 failed at run time, 2 command line, configuration or input file,\n"
    "3 stopped by the user, 4 device fault.";

}  // namespace

int RunCommandLine(int argc, char** argv) {
  CLI::App app("Measures reflectance with a gonioreflectometer that chooses its own poses.",
               "gonio");
  app.set_version_flag("--version", std::string("gonio ") + GONIO_VERSION);
  app.footer(kFooter);
  Action chosen;
  for (const Command& command : kCommands) {
    CLI::App* sub = app.add_subcommand(command.name, command.help);
    Action action = command.set_up(*sub);
    sub->callback([&chosen, action] { chosen = action; });
  }
  if (argc < 2) throw ConfigError("a command is needed; see gonio --help");
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& e) {
    if (e.get_exit_code() == 0) return app.exit(e);  // help and version: prints
    throw ConfigError(std::string(e.what()) + "; see gonio --help");
  }
  if (!chosen) throw ConfigError("a command is needed; see gonio --help");
  return chosen();
}

}  // namespace gonio
