// SPDX-License-Identifier: Apache-2.0
// The commands of `gonio`: one struct of options and one function each, one .cpp each. cli.cpp
// fills the options in from the command line.

#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "core/units.h"

namespace gonio {

enum ExitCode {
  kDone = 0,
  kFailed = 1,  // at run time: a full disk, ...
  kUsage = 2,   // the command line, a configuration or an input file
  kStoppedByUser = 3,
  kDeviceFaultExit = 4,
};

// Every command returns an exit code; it throws ConfigError (kUsage) or std::exception (kFailed).

struct RunOptions {
  std::string rig = "sim-rig.yaml";  // these three: a path, or the name of a file we come with
  std::string plan = "plan-information.yaml";
  std::string material;  // what the simulated rig measures; empty: kDefaultMaterial
  std::filesystem::path out;
  int max_poses = 0;  // 0: the plan's
  std::uint64_t seed = 1;
  std::string prior;                  // "none", "generic", a prior file, or empty: the plan's
  std::filesystem::path calibration;  // folder, in place of the rig's
  bool quiet = false;
  std::string notify;  // a command that is told what goes wrong; empty: none
  bool park = false;   // at a clean end

  // A session to go on with. All but the next two and those three are then its own; those that are
  // named here all the same are changes.
  std::filesystem::path resume;
  bool accept_changed = false;
  double max_reference_change_percent = 10;
};
int RunCommand(const RunOptions& options);
// Its part where `resume` is given.
int ResumeSession(const RunOptions& options);

struct RescueOptions {
  std::filesystem::path session;
  std::filesystem::path out;  // to make; empty: only says what is wrong
};
// kFailed: something is lost.
int RescueCommand(const RescueOptions& options);

struct ReplayOptions {
  std::filesystem::path session;
  bool rereduce = false;              // samples from the raw frames
  std::filesystem::path calibration;  // with these files instead of the session's
  bool refit = false;
  std::string plan;           // another plan, to see what it would have chosen
  std::string rig;            // it would have been on, of an imported session; empty: the session's
  std::filesystem::path out;  // folder for samples and fit; empty: none
  double speed = 0;           // > 0: shows the turns so many times as fast as they were
  std::string json;           // file, or "-" for standard output; empty: text only
};
// kFailed: the planner decides otherwise.
int ReplayCommand(const ReplayOptions& options);

struct CalibrateOptions {
  std::string step;  // "darks", "photon-transfer", "flat", "stray-light", "standard"
  std::string rig = "sim-rig.yaml";
  std::filesystem::path out;  // folder; empty: the rig's
  std::string material;       // what a simulated camera has before it; empty: what the step wants
  double trap_radius_mm = 0;  // of a trap in a tile; 0: the rig's patch
  std::string standard;       // a reference standard's file
  std::optional<double> theta_i_deg;
  std::optional<double> theta_o_deg;
  int frames = 0;  // 0: the step's own
  bool again = false;
  bool keep_frames = false;
  std::uint64_t seed = 1;
  bool quiet = false;
};
int CalibrateCommand(const CalibrateOptions& options);
int CalibrateStatusCommand(const CalibrateOptions& options);

struct CalibrateGeometryOptions {
  std::string rig;
  std::filesystem::path out;     // calibration folder
  std::string target = "board";  // "board", "mirror", or "none": fit again
  int columns = 9;               // inner corners
  int rows = 6;
  double square_mm = 5;
  std::uint64_t seed = 1;  // of simulated noise
  bool quiet = false;
};
int CalibrateGeometryCommand(const CalibrateGeometryOptions& options);

struct CalibrateTimeOptions {
  std::vector<std::filesystem::path> sessions;
  std::filesystem::path out;  // .yaml
};
int CalibrateTimeCommand(const CalibrateTimeOptions& options);

struct FitCommandOptions {
  std::filesystem::path input;  // .binary, .bsdf, material .yaml, .csv or a session
  std::filesystem::path out;
  std::string method = "continuous";  // "em", "joint", "continuous"
  std::string lobes;                  // "1" .. "5", "auto" (by BIC), or empty: the prior's, or 3
  int keep_every = 1;                 // thinning of theta_h
  double slice_step_deg = 5;
  std::string prior = "generic";
};
int FitCommand(const FitCommandOptions& options);

struct StudyOptions {
  std::filesystem::path study;                   // a study file
  std::vector<std::filesystem::path> materials;  // folders to look for its materials in
  std::filesystem::path out;                     // a folder; a study in it is continued
  int threads = 0;                               // 0: every core
  bool quiet = false;
};
int StudyCommand(const StudyOptions& options);

struct PlotOptions {
  std::filesystem::path input;  // a fit, a session or a study folder
  std::filesystem::path out;    // .png or .svg
  std::string kind;             // "slice", "error-map", "density"; empty: what suits the input
  std::string reference;        // what was fitted: the data of a slice, the truth of an error map
  double theta_d_deg = 5;
  std::string colour = "green";
  int keep_every = 1;  // which theta_h of the reference to show as data
  std::string method;  // of a study: only this one
};
int PlotCommand(const PlotOptions& options);

struct RenderCommandOptions {
  std::vector<std::string> inputs;          // several: side by side
  std::vector<std::filesystem::path> outs;  // .png tone-mapped, .hdr or .exr linear
  std::string light = "point";              // "point" or "env"
  std::filesystem::path environment;        // .hdr or .exr; empty: the built-in sky
  int size = 256;
  int samples = 256;
  std::string exposure = "auto";  // or a number: linear values are multiplied by it
};
int RenderCommand(const RenderCommandOptions& options);

struct ExportOptions {
  std::filesystem::path input;
  std::string format;  // "merl", "csv", or empty: only frames
  std::filesystem::path out;
  std::filesystem::path frames;  // a folder to make for a session's raw frames; empty: none
};
int ExportCommand(const ExportOptions& options);

struct CompareOptions {
  std::filesystem::path reference;
  std::filesystem::path other;
  std::filesystem::path json;  // empty: none
  double max_theta_deg = 80;
  int phi_stride = 1;
  bool render = true;  // compare renders, too
};
int CompareCommand(const CompareOptions& options);

struct SimulateOptions {
  std::string rig = "sim-rig.yaml";
  std::vector<std::string> plans;
  std::vector<std::string> materials;  // none: drawn from the prior
  std::string prior;                   // as for run
  double target = 0;                   // an error (MALE); 0: none asked for
  int draws = 8;                       // materials, where none is named
  int max_poses = 0;
  std::uint64_t seed = 1;
  int seeds = 1;
  int threads = 0;  // 0: every core
  std::filesystem::path json;
  bool quiet = false;
};
int SimulateCommand(const SimulateOptions& options);

struct PriorLearnOptions {
  std::vector<std::string> materials;  // .binary, .bsdf, material .yaml, fits, sessions
  std::filesystem::path out;
};
int PriorLearnCommand(const PriorLearnOptions& options);

struct DevicesOptions {
  std::vector<std::string> gige_addresses;  // of GigE Vision cameras, which are asked
  bool gige = false;                        // all others are searched for by a broadcast
  std::filesystem::path json;               // empty: none; "-": instead of the table
};
int DevicesCommand(const DevicesOptions& options);

struct SimDevicesOptions {
  std::string rig = "bench-wire.yaml";
  double speed = 1;                  // of the doubles' moves, > 0
  std::string material;              // that a double of a camera sees; empty: kDefaultMaterial
  std::vector<std::string> command;  // that sees them; empty: a shell

  // Of a double of the rig's camera.
  double packet_loss_percent = 0;
  int camera_late_frames = 0;        // that a change of the exposure time takes to be in force
  bool camera_chunk_data = false;    // its frames say how they were taken
  int camera_gone_after = 0;         // exposures, after which it is unplugged; 0: never
  double camera_gone_for_s = 0;      // until it is plugged in again; 0: for good
  std::filesystem::path frames_log;  // SHA-256 of every frame's counts as it was sent; empty: none
};
// What the command ended with.
int SimDevicesCommand(const SimDevicesOptions& options);

struct DoctorOptions {
  std::string rig;   // whose ports are tried, too; empty: none
  std::string json;  // file, or "-" for standard output; empty: text only
};
// kFailed if anything is wrong.
int DoctorCommand(const DoctorOptions& options);

struct CheckOptions {
  std::string rig;            // a path, or the name of a file we come with
  std::filesystem::path out;  // picture, .png or .svg; empty: none
  std::string json;           // file, or "-" for standard output; empty: text only
};
// kFailed if nothing can be measured.
int CheckCommand(const CheckOptions& options);

struct ReportOptions {
  std::filesystem::path session;
  std::filesystem::path out;  // empty: report.html in the session
};
int ReportCommand(const ReportOptions& options);

}  // namespace gonio
