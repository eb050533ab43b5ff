// SPDX-License-Identifier: Apache-2.0
#include "brdf/open.h"

#include <gtest/gtest.h>

#include "brdf/merl_table.h"
#include "core/error.h"
#include "tests/core/temp_dir.h"

namespace gonio {
namespace {

TEST(OpenBrdf, ChoosesTheReaderByExtension) {
  const TempDir dir;
  MerlTable::FromFunction("x", [](auto&) { return Rgb(1, 1, 1); }).Write(dir / "grey.BINARY");
  EXPECT_EQ(OpenBrdf(dir / "grey.BINARY")->name(), "grey");
  const std::string yaml =
      "version: 1\nname: matt\nlayers:\n  - {kind: lambert, albedo: [1, 1, 1]}\n";
  EXPECT_EQ(OpenBrdf(dir.File("a.yaml", yaml))->name(), "matt");
  EXPECT_EQ(OpenBrdf(dir.File("a.yml", yaml))->name(), "matt");
}

TEST(OpenBrdf, NamesAFileThatIsMissing) {
  const TempDir dir;
  for (const char* name : {"x.binary", "x.yaml"}) {
    EXPECT_EQ(MessageOf<ConfigError>([&] { OpenBrdf(dir / name); }),
              (dir / name).string() + ": cannot read: No such file or directory");
  }
}

TEST(OpenBrdf, RefusesOtherExtensionsAndSaysWhichItKnows) {
  EXPECT_EQ(MessageOf<ConfigError>([] { OpenBrdf("a/b.exr"); }),
            "a/b.exr: has the extension \".exr\", must be .binary (MERL table), .bsdf (RGL) or "
            ".yaml (material)");
  EXPECT_EQ(MessageOf<ConfigError>([] { OpenBrdf("paint"); }),
            "paint: has the extension \"\", must be .binary (MERL table), .bsdf (RGL) or .yaml "
            "(material)");
}

}  // namespace
}  // namespace gonio
