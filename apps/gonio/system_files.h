// SPDX-License-Identifier: Apache-2.0
// What the system tells about devices, in files of one line.

#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace gonio {

// The first line, without its end; empty if there is none.
std::string SystemAttribute(const std::filesystem::path& file);
// What is in a folder, in order; empty if there is none.
std::vector<std::filesystem::path> SystemEntries(const std::filesystem::path& dir);
// Whether this user may read and write it.
bool MayOpen(const std::filesystem::path& node);
// The file of /dev through which a USB device is opened, by its folder in /sys/bus/usb/devices:
// "dev/bus/usb/001/006".
std::filesystem::path UsbNode(const std::filesystem::path& device);
// The folder of the device of an interface: "1-2:1.0" is one of "1-2", beside it in the list.
std::filesystem::path UsbDeviceOf(const std::filesystem::path& interface);

}  // namespace gonio
