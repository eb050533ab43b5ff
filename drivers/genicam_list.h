// SPDX-License-Identifier: Apache-2.0
// Which GenICam cameras there are.

#pragma once

#include <mutex>
#include <string>
#include <vector>

#include "core/error.h"

namespace gonio {

struct GenicamCameraInfo {
  std::string protocol;  // "USB3Vision", "GigEVision"
  std::string vendor;
  std::string model;
  std::string serial;   // "" if this user may not ask it
  std::string id;       // Aravis' name of it, as GenicamSettings::device_id
  std::string address;  // of a GigE Vision camera: "192.168.1.20"
  bool taken = false;   // another program controls it, as far as was asked
};

// USB3 Vision cameras. Nothing is sent on a network.
std::vector<GenicamCameraInfo> ListUsbCameras();

// GigE Vision cameras, by a broadcast on every interface. Takes a second.
std::vector<GenicamCameraInfo> SearchGigeCameras();

// The GigE Vision camera at this IPv4 address; nothing is sent elsewhere. It is controlled for a
// moment if nobody else does. kRefused: it is no address, or no camera answers there, which takes
// some seconds.
Result<GenicamCameraInfo> AskGigeCamera(const std::string& address);

// Aravis' list of devices is one of the whole program: held by whoever uses it.
std::mutex& GenicamListMutex();

}  // namespace gonio
