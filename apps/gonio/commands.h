// SPDX-License-Identifier: Apache-2.0
// The commands of `gonio`: one struct of options and one function each, one .cpp each. cli.cpp
// fills the options in from the command line.

#pragma once

#include <cstdint>
#include <filesystem>
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
  std::string prior;  // "generic", a prior file, or empty: the plan's
  bool quiet = false;
};
int RunCommand(const RunOptions& options);

struct FitCommandOptions {
  std::filesystem::path input;  // .binary, .csv or a session
  std::filesystem::path out;
  int lobes = 0;  // 0: the prior's, or 3
  std::string prior = "generic";
};
int FitCommand(const FitCommandOptions& options);

struct ExportOptions {
  std::filesystem::path input;
  std::string format;  // "merl" or "csv"
  std::filesystem::path out;
};
int ExportCommand(const ExportOptions& options);

struct CompareOptions {
  std::filesystem::path reference;
  std::filesystem::path other;
  std::filesystem::path json;  // empty: none
  double max_theta_deg = 80;
  int phi_stride = 1;
};
int CompareCommand(const CompareOptions& options);

struct SimulateOptions {
  std::string rig = "sim-rig.yaml";
  std::vector<std::string> plans;
  std::vector<std::string> materials;
  std::string prior;  // as for run
  int max_poses = 0;
  std::uint64_t seed = 1;
  int seeds = 1;
  std::filesystem::path json;
  bool quiet = false;
};
int SimulateCommand(const SimulateOptions& options);

struct ReportOptions {
  std::filesystem::path session;
  std::filesystem::path out;  // empty: report.html in the session
};
int ReportCommand(const ReportOptions& options);

}  // namespace gonio
