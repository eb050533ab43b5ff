// SPDX-License-Identifier: Apache-2.0
#include "core/file.h"

#include <gtest/gtest.h>

#include "core/error.h"
#include "tests/core/temp_dir.h"

namespace gonio {
namespace {

namespace fs = std::filesystem;

TEST(ReadTextFile, ReturnsEveryByte) {
  const TempDir dir;
  const std::string text("a\r\nb\0c", 6);
  EXPECT_EQ(ReadTextFile(dir.File("x", text)), text);
  EXPECT_EQ(ReadTextFile(dir.File("empty", "")), "");
}

TEST(ReadTextFile, NamesAMissingFileAndTheReason) {
  const TempDir dir;
  const fs::path path = dir / "none.yaml";
  EXPECT_EQ(MessageOf<ConfigError>([&] { ReadTextFile(path); }),
            path.string() + ": cannot read: No such file or directory");
}

TEST(ReadTextFile, RefusesAFolder) {
  const TempDir dir;
  EXPECT_EQ(MessageOf<ConfigError>([&] { ReadTextFile(dir.path()); }),
            dir.path().string() + ": cannot read: is a directory");
}

TEST(WriteFileAtomically, WritesTheFileAndNothingElse) {
  const TempDir dir;
  WriteFileAtomically(dir / "x", [](std::ostream& out) { out << "hello"; });
  EXPECT_EQ(ReadTextFile(dir / "x"), "hello");
  EXPECT_EQ(dir.CountFiles(), 1u);
}

TEST(WriteFileAtomically, ShowsTheOldFileUntilTheNewOneIsWhole) {
  const TempDir dir;
  const fs::path path = dir.File("x", "old");
  WriteFileAtomically(path, [&](std::ostream& out) {
    out << "new" << std::flush;
    EXPECT_EQ(ReadTextFile(path), "old");
  });
  EXPECT_EQ(ReadTextFile(path), "new");
}

TEST(WriteFileAtomically, KeepsTheOldFileAndLeavesNothingBehindWhenTheWriterThrows) {
  const TempDir dir;
  const fs::path path = dir.File("x", "old");
  const auto write = [&] {
    WriteFileAtomically(path, [](std::ostream& out) {
      out << "half" << std::flush;
      throw std::logic_error("no more");
    });
  };
  EXPECT_EQ(MessageOf<std::logic_error>(write), "no more");
  EXPECT_EQ(ReadTextFile(path), "old");
  EXPECT_EQ(dir.CountFiles(), 1u);
}

// A full disk, without filling one: the part file is a link to the device that never has space.
void ExpectFullDiskReported(std::size_t bytes) {
  const TempDir dir;
  const fs::path path = dir.File("x", "old");
  fs::create_symlink("/dev/full", dir / "x.part");
  const auto write = [&] {
    WriteFileAtomically(path, [&](std::ostream& out) { out << std::string(bytes, '.'); });
  };
  EXPECT_EQ(MessageOf<std::runtime_error>(write),
            path.string() + ": cannot write: No space left on device");
  EXPECT_EQ(ReadTextFile(path), "old");
  EXPECT_EQ(dir.CountFiles(), 1u);
}

TEST(WriteFileAtomically, ReportsADiskThatIsFullAtTheLastFlush) { ExpectFullDiskReported(10); }

TEST(WriteFileAtomically, ReportsADiskThatFillsUpMeanwhile) { ExpectFullDiskReported(1 << 20); }

TEST(WriteFileAtomically, ReportsAMissingFolder) {
  const TempDir dir;
  const fs::path path = dir / "no" / "x";
  EXPECT_EQ(MessageOf<std::runtime_error>([&] { WriteFileAtomically(path, [](auto&) {}); }),
            path.string() + ": cannot write: No such file or directory");
}

TEST(WriteFileAtomically, LeavesNothingBehindWhenTheTargetIsAFolder) {
  const TempDir dir;
  fs::create_directory(dir / "x");
  EXPECT_THROW(WriteFileAtomically(dir / "x", [](std::ostream& out) { out << "text"; }),
               std::runtime_error);
  EXPECT_EQ(dir.CountFiles(), 1u);
}

}  // namespace
}  // namespace gonio
