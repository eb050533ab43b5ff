// SPDX-License-Identifier: Apache-2.0
// The arrows of docs/architecture.md, checked against every include.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <map>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "core/file.h"

namespace gonio {
namespace {

using testing::IsEmpty;

// Module -> what it may include beside itself.
const std::map<std::string, std::set<std::string>> kArrows = {
    {"core", {}},
    {"brdf", {"core"}},
    {"drivers", {"core"}},
    {"fitting", {"brdf", "core"}},
    {"planner", {"fitting", "brdf", "core"}},
    {"acquisition", {"planner", "fitting", "drivers", "brdf", "core"}},
    {"sim", {"drivers", "brdf", "core"}},
    {"apps", {"acquisition", "sim", "planner", "fitting", "drivers", "brdf", "core"}},
};

// Third parties that may appear in these modules only, and, if `sources_only`, not in headers.
struct Fence {
  std::string header;
  std::set<std::string> modules;
  bool sources_only;
};
const std::vector<Fence> kFences = {
    {"yaml-cpp/", {"core"}, true},
    {"sqlite3.h", {"acquisition"}, false},
    {"CLI/", {"apps"}, false},
    {"nlohmann/", {"acquisition", "apps"}, false},
    {"fmt/", {"core", "brdf", "drivers", "fitting", "planner", "acquisition", "sim", "apps"}, true},
    {"libserialport.h", {"drivers"}, true},
    {"libusb.h", {"drivers"}, true},
    {"umockdev.h", {"sim"}, true},
    {"arv.h", {"drivers", "sim"}, true},
    {"glib", {"drivers", "sim"}, true},
    {"openssl/", {"core"}, true},
    {"ceres/", {"fitting", "acquisition"}, true},
    {"fcl/", {"acquisition"}, true},
    {"opencv2/", {"brdf", "acquisition"}, true},
};

struct Include {
  std::filesystem::path file;  // relative to the source tree
  std::string header;
};

std::vector<Include> IncludesOf(const std::string& module) {
  const std::filesystem::path root = GONIO_SOURCE_DIR;
  std::vector<Include> includes;
  for (const auto& entry : std::filesystem::recursive_directory_iterator(root / module)) {
    const auto extension = entry.path().extension();
    if (extension != ".h" && extension != ".cpp") continue;
    std::istringstream lines(ReadTextFile(entry.path()));
    for (std::string line; std::getline(lines, line);) {
      if (!line.starts_with("#include ")) continue;
      const auto open = line.find_first_of("<\"");
      const auto close = line.find_last_of(">\"");
      includes.push_back(
          {std::filesystem::relative(entry.path(), root), line.substr(open + 1, close - open - 1)});
    }
  }
  return includes;
}

TEST(Architecture, ModulesIncludeOnlyAlongTheArrows) {
  std::vector<std::string> offences;
  for (const auto& [module, allowed] : kArrows) {
    const std::vector<Include> includes = IncludesOf(module);
    ASSERT_FALSE(includes.empty()) << module;
    for (const Include& include : includes) {
      const std::string target = include.header.substr(0, include.header.find('/'));
      const bool ours = kArrows.contains(target);
      if (ours && target != module && !allowed.contains(target)) {
        offences.push_back(include.file.string() + " includes " + include.header);
      }
    }
  }
  EXPECT_THAT(offences, IsEmpty());
}

TEST(Architecture, ThirdPartiesStayBehindTheirFences) {
  std::vector<std::string> offences;
  for (const auto& [module, allowed] : kArrows) {
    for (const Include& include : IncludesOf(module)) {
      for (const Fence& fence : kFences) {
        if (!include.header.starts_with(fence.header)) continue;
        const bool header = include.file.extension() == ".h";
        if (!fence.modules.contains(module) || (fence.sources_only && header)) {
          offences.push_back(include.file.string() + " includes " + include.header);
        }
      }
    }
  }
  EXPECT_THAT(offences, IsEmpty());
}

}  // namespace
}  // namespace gonio
