// SPDX-License-Identifier: Apache-2.0
// Runs the built binary as a user would, in a folder of its own.

#pragma once

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <sys/wait.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <string>

#include "core/file.h"
#include "tests/core/temp_dir.h"

namespace gonio {

struct Finished {
  int code = -1;  // exit code; 128 + n: killed by signal n
  std::string out;
  std::string err;
};

class GonioTest : public testing::Test {
 protected:
  // `line` is a shell command in the test's folder; $GONIO is the binary.
  Finished Shell(const std::string& line) {
    const std::string command =
        fmt::format("cd '{}' && export GONIO='{}' && {{ {}\n}} > '{}' 2> '{}'", work().string(),
                    GONIO_BINARY, line, (logs_ / "out").string(), (logs_ / "err").string());
    const int status = std::system(command.c_str());
    return {WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status),
            ReadTextFile(logs_ / "out"), ReadTextFile(logs_ / "err")};
  }
  Finished Gonio(const std::string& arguments) { return Shell("\"$GONIO\" " + arguments); }

  // Runs and expects success, silence on standard error included.
  Finished Expect(const std::string& arguments) {
    Finished finished = Gonio(arguments);
    EXPECT_EQ(finished.code, 0) << "gonio " << arguments << "\n" << finished.err;
    EXPECT_EQ(finished.err, "");
    return finished;
  }

  // Expects this exit code and one line on standard error that holds `words`.
  void ExpectRefused(const Finished& finished, int code, const std::vector<std::string>& words) {
    EXPECT_EQ(finished.code, code) << finished.err;
    EXPECT_THAT(finished.err, testing::StartsWith("gonio: "));
    EXPECT_EQ(std::count(finished.err.begin(), finished.err.end(), '\n'), 1) << finished.err;
    for (const std::string& word : words) EXPECT_THAT(finished.err, testing::HasSubstr(word));
  }

  const std::filesystem::path& work() const { return work_.path(); }
  std::filesystem::path File(const std::string& name, const std::string& text) {
    return work_.File(name, text);
  }
  // data/NAME.yaml: five materials to learn from, unlike in colour and gloss.
  void WriteCoatings() {
    std::filesystem::create_directories(work() / "data");
    Coated("enamel", "0.70, 0.66, 0.50", 0.12);
    Coated("glaze", "0.06, 0.22, 0.40", 0.20);
    Coated("lacquer", "0.30, 0.04, 0.03", 0.15);
    Coated("paint", "0.11, 0.32, 0.36", 0.30);
    Coated("rubber", "0.05, 0.05, 0.06", 0.45);
  }
  // Names of what is in the test's folder.
  std::vector<std::string> Files() const {
    std::vector<std::string> names;
    for (const auto& entry : std::filesystem::directory_iterator(work())) {
      names.push_back(entry.path().filename().string());
    }
    std::sort(names.begin(), names.end());
    return names;
  }

  static std::string Config(const std::string& name) {
    return ReadTextFile(std::string(GONIO_SOURCE_DIR) + "/configs/" + name);
  }
  // `text` with the only occurrence of `from` replaced.
  static std::string With(std::string text, const std::string& from, const std::string& to) {
    const std::size_t at = text.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    if (at != std::string::npos) text.replace(at, from.size(), to);
    return text;
  }

 private:
  void Coated(const std::string& name, const std::string& albedo, double roughness) {
    File("data/" + name + ".yaml", fmt::format("version: 1\nname: {}\nlayers:\n"
                                               "  - {{kind: lambert, albedo: [{}]}}\n"
                                               "  - {{kind: ggx, roughness: {}, ior: 1.5}}\n",
                                               name, albedo, roughness));
  }

  TempDir work_;
  TempDir logs_;
};

}  // namespace gonio
