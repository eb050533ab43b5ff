// SPDX-License-Identifier: Apache-2.0
#include <gtest/gtest.h>

#include "brdf/analytic.h"
#include "core/error.h"
#include "tests/core/temp_dir.h"

namespace gonio {
namespace {

const std::filesystem::path kMaterials =
    std::filesystem::path(GONIO_SOURCE_DIR) / "configs/materials";

TEST(ParseMaterial, BuildsWhatIsDescribed) {
  const auto brdf = ParseMaterial(
      "version: 1\nname: test\nlayers:\n"
      "  - {kind: oren_nayar, albedo: [0.1, 0.2, 0.3], roughness: 0.4}\n"
      "  - {kind: retro, roughness: 0.3, strength: [0.1, 0.1, 0.1]}\n"
      "  - {kind: ggx, roughness: 0.2, f0: [0.04, 0.05, 0.06]}\n",
      "x.yaml");
  const AnalyticBrdf same("test", {OrenNayar{{0.1, 0.2, 0.3}, 0.4},
                                   Retro{.roughness = 0.3, .strength = {0.1, 0.1, 0.1}},
                                   Ggx{.roughness = 0.2, .f0 = {0.04, 0.05, 0.06}}});
  EXPECT_EQ(brdf->name(), "test");
  for (const double theta_h : {0.0, 0.2, 0.7}) {
    const HalfDiff angles{theta_h, 0.4, 1};
    EXPECT_TRUE((*brdf->Eval(angles) == *same.Eval(angles)).all());
  }
}

TEST(LoadMaterial, ReadsTheMaterialsThatComeWithTheProgram) {
  EXPECT_EQ(LoadMaterial(kMaterials / "satin-paint.yaml")->name(), "satin paint");
  EXPECT_EQ(LoadMaterial(kMaterials / "glossy-plastic.yaml")->name(), "glossy plastic");
  EXPECT_EQ(LoadMaterial(kMaterials / "retro-cloth.yaml")->name(), "retro cloth");
}

struct BadMaterial {
  const char* label;
  const char* text;
  const char* complaint;
};

void PrintTo(const BadMaterial& bad, std::ostream* out) { *out << bad.label; }

class BadMaterials : public testing::TestWithParam<BadMaterial> {};

TEST_P(BadMaterials, AreRefusedWithLineAndKey) {
  EXPECT_EQ(MessageOf<ConfigError>([] { ParseMaterial(GetParam().text, "m.yaml"); }),
            GetParam().complaint);
}

constexpr const char* kNoLayers = "version: 1\nname: x\n";
#define LAYER(text) "version: 1\nname: x\nlayers:\n  - " text "\n"

INSTANTIATE_TEST_SUITE_P(
    Yaml, BadMaterials,
    testing::Values(
        BadMaterial{"NoVersion", "name: x\nlayers: []\n", "m.yaml:1: version: is missing"},
        BadMaterial{"OtherVersion", "version: 2\nname: x\n",
                    "m.yaml:1: version: is 2, must be between 1 and 1"},
        BadMaterial{"NoName", "version: 1\nlayers: []\n", "m.yaml:1: name: is missing"},
        BadMaterial{"NoLayers", kNoLayers, "m.yaml:1: layers: is missing"},
        BadMaterial{"EmptyLayers", "version: 1\nname: x\nlayers: []\n",
                    "m.yaml:3: layers: must be a list that is not empty"},
        BadMaterial{"UnknownKind", LAYER("{kind: phong}"),
                    "m.yaml:4: layers[0].kind: is \"phong\", must be one of lambert, oren_nayar, "
                    "ggx, retro"},
        BadMaterial{"NoKind", LAYER("{albedo: [0, 0, 0]}"), "m.yaml:4: layers[0].kind: is missing"},
        BadMaterial{"UnknownRootKey",
                    "version: 1\nname: x\nalbedo: 1\nlayers:\n"
                    "  - {kind: lambert, albedo: [0, 0, 0]}\n",
                    "m.yaml:3: albedo: is not a known key"},
        BadMaterial{"KeyOfAnotherKind", LAYER("{kind: lambert, albedo: [0, 0, 0], roughness: 1}"),
                    "m.yaml:4: layers[0].roughness: is not a known key"},
        BadMaterial{"NoAlbedo", LAYER("{kind: lambert}"), "m.yaml:4: layers[0].albedo: is missing"},
        BadMaterial{"TwoChannels", LAYER("{kind: lambert, albedo: [0, 0]}"),
                    "m.yaml:4: layers[0].albedo: must be a list of 3 numbers"},
        BadMaterial{"AlbedoAboveOne", LAYER("{kind: lambert, albedo: [0, 0, 1.5]}"),
                    "m.yaml:4: layers[0].albedo: holds 1.5, must be between 0 and 1"},
        BadMaterial{"NegativeAlbedo", LAYER("{kind: lambert, albedo: [0, -1, 1]}"),
                    "m.yaml:4: layers[0].albedo: holds -1, must be between 0 and 1"},
        BadMaterial{"OrenNayarTooRough",
                    LAYER("{kind: oren_nayar, albedo: [0, 0, 0], roughness: 1.1}"),
                    "m.yaml:4: layers[0].roughness: is 1.1, must be between 0 and 1"},
        BadMaterial{"OrenNayarWithoutRoughness", LAYER("{kind: oren_nayar, albedo: [0, 0, 0]}"),
                    "m.yaml:4: layers[0].roughness: is missing"},
        BadMaterial{"GgxTooSmooth", LAYER("{kind: ggx, ior: 1.5, roughness: 0.001}"),
                    "m.yaml:4: layers[0].roughness: is 0.001, must be between 0.01 and 1"},
        BadMaterial{"GgxWithBothColours",
                    LAYER("{kind: ggx, ior: 1.5, f0: [0, 0, 0], roughness: 0.1}"),
                    "m.yaml:4: layers[0].ior: give either f0 or ior"},
        BadMaterial{"GgxWithNoColour", LAYER("{kind: ggx, roughness: 0.1}"),
                    "m.yaml:4: layers[0].f0: give either f0 or ior"},
        BadMaterial{"GgxIorBelowOne", LAYER("{kind: ggx, roughness: 0.1, ior: 0.9}"),
                    "m.yaml:4: layers[0].ior: is 0.9, must be between 1.01 and 4"},
        BadMaterial{"GgxBadF0", LAYER("{kind: ggx, roughness: 0.1, f0: [0, 0, 2]}"),
                    "m.yaml:4: layers[0].f0: holds 2, must be between 0 and 1"},
        BadMaterial{"RetroWithoutStrength", LAYER("{kind: retro, roughness: 0.1}"),
                    "m.yaml:4: layers[0].strength: is missing"},
        BadMaterial{"RetroTooRough", LAYER("{kind: retro, roughness: 2, strength: [0, 0, 0]}"),
                    "m.yaml:4: layers[0].roughness: is 2, must be between 0.01 and 1"},
        BadMaterial{"TextForANumber", LAYER("{kind: ggx, roughness: shiny, ior: 1.5}"),
                    "m.yaml:4: layers[0].roughness: is \"shiny\", must be a finite number"}),
    [](const auto& test) { return test.param.label; });

}  // namespace
}  // namespace gonio
