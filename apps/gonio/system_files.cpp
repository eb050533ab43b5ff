// SPDX-License-Identifier: Apache-2.0
#include "apps/gonio/system_files.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <system_error>

namespace gonio {

namespace fs = std::filesystem;

std::string SystemAttribute(const fs::path& file) {
  std::ifstream in(file);
  std::string line;
  std::getline(in, line);
  return line;
}

std::vector<fs::path> SystemEntries(const fs::path& dir) {
  std::vector<fs::path> entries;
  std::error_code absent;
  for (const auto& entry : fs::directory_iterator(dir, absent)) entries.push_back(entry.path());
  std::sort(entries.begin(), entries.end());
  return entries;
}

bool MayOpen(const fs::path& node) { return ::access(node.c_str(), R_OK | W_OK) == 0; }

fs::path UsbNode(const fs::path& device) {
  const auto number = [&](const char* name) {
    return std::atoi(SystemAttribute(device / name).c_str());
  };
  return fmt::format("dev/bus/usb/{:03d}/{:03d}", number("busnum"), number("devnum"));
}

fs::path UsbDeviceOf(const fs::path& interface) {
  const std::string name = interface.filename().string();
  return interface.parent_path() / name.substr(0, name.find(':'));
}

}  // namespace gonio
