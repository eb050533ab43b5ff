// SPDX-License-Identifier: Apache-2.0
#include <utility>

#include "brdf/analytic.h"
#include "core/config.h"

namespace gonio {
namespace {

Rgb ReadRgb(const ConfigNode& node, const char* key) {
  const auto numbers = node.Numbers(key, kChannels, Range::Between(0, 1));
  return {numbers[0], numbers[1], numbers[2]};
}

double ReadLobeRoughness(const ConfigNode& node) {
  return node.Number("roughness", Range::Between(0.01, 1));
}

Ggx ReadGgx(const ConfigNode& node) {
  Ggx layer{.roughness = ReadLobeRoughness(node)};
  if (node.Has("ior") == node.Has("f0")) {
    node.Fail(node.Has("ior") ? "ior" : "f0", "give either f0 or ior");
  }
  if (node.Has("ior")) {
    layer.ior = node.Number("ior", Range::Between(1.01, 4));
  } else {
    layer.f0 = ReadRgb(node, "f0");
  }
  return layer;
}

Layer ReadLayer(const ConfigNode& node) {
  const std::string kind = node.Choice("kind", {"lambert", "oren_nayar", "ggx", "retro"});
  if (kind == "lambert") return Lambert{.albedo = ReadRgb(node, "albedo")};
  if (kind == "ggx") return ReadGgx(node);
  if (kind == "retro") {
    return Retro{.roughness = ReadLobeRoughness(node), .strength = ReadRgb(node, "strength")};
  }
  return OrenNayar{.albedo = ReadRgb(node, "albedo"),
                   .roughness = node.Number("roughness", Range::Between(0, 1))};
}

std::unique_ptr<Brdf> Read(const ConfigNode& root) {
  root.Integer("version", 1, 1);
  std::string name = root.Text("name");
  std::vector<Layer> layers;
  for (const ConfigNode& node : root.MapList("layers")) layers.push_back(ReadLayer(node));
  root.RefuseUnknownKeys();
  return std::make_unique<AnalyticBrdf>(std::move(name), std::move(layers));
}

}  // namespace

std::unique_ptr<Brdf> LoadMaterial(const std::filesystem::path& path) {
  return Read(ConfigNode::Load(path));
}

std::unique_ptr<Brdf> ParseMaterial(const std::string& text, const std::string& name) {
  return Read(ConfigNode::Parse(text, name));
}

}  // namespace gonio
