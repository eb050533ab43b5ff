// SPDX-License-Identifier: Apache-2.0
// What a machine needs to take a camera's frames as fast as they come.

#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "apps/gonio/doctor_checks.h"

namespace gonio {

// `root`: below which the system's files are read; another one in tests only.

// Whether USB3 Vision cameras that are plugged in may be opened.
std::vector<Finding> CheckUsbCameras(const std::filesystem::path& root = "/");

// Whether the system lets a camera's frames in: for GigE Vision what a socket may hold, and the
// size of packets on the interface towards its address; for USB3 Vision what transfers may hold.
// Where only its serial number or name is known, it may be either. Sends nothing. Empty for a
// camera that is simulated.
std::vector<Finding> CheckCameraOf(const RigConfig& rig, const std::filesystem::path& root = "/");

// The network interface by which packets to this IPv4 address leave: "eth0"; empty if there is
// none.
std::string InterfaceTowards(const std::string& address);

}  // namespace gonio
