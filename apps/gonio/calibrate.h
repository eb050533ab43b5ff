// SPDX-License-Identifier: Apache-2.0
// gonio calibrate: what each step needs. The steps are functions like commands.h's.

#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace gonio {

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

}  // namespace gonio
