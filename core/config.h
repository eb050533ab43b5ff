// SPDX-License-Identifier: Apache-2.0
// Typed, strict reads of YAML files. Every complaint is one line naming file, line and key.

#pragma once

#include <cstdint>
#include <filesystem>
#include <limits>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

namespace gonio {

// A text of one line as a YAML string that means nothing but itself.
std::string YamlQuoted(std::string_view text);

// The values a number may take, for the check and for the message: Range::Positive() and so on.
struct Range {
  double min = -std::numeric_limits<double>::infinity();
  double max = std::numeric_limits<double>::infinity();
  bool min_open = false;  // the minimum itself is refused

  static Range Any() { return {}; }
  static Range Positive() { return {.min = 0, .min_open = true}; }
  static Range NonNegative() { return {.min = 0}; }
  static Range Between(double min, double max) { return {.min = min, .max = max}; }
};

// A mapping ("a: 1") in a YAML file, or one inside it.
//
//   ConfigNode root = ConfigNode::Load("rig.yaml");
//   double speed = root.Map("axes").Map("tilt").Number("max_speed_deg_s", Range::Positive());
//   root.RefuseUnknownKeys();   // last: whatever nobody asked for is a typing error
//
// All reads throw ConfigError "rig.yaml:14: axes.tilt.max_speed_deg_s: is -5, must be > 0".
// Numbers must be finite. A node is a cheap handle; copies share the record of what was read.
class ConfigNode {
 public:
  // Throws ConfigError on an unreadable file, broken YAML, a second document, a duplicate key, an
  // alias that contains itself, or a root that is no mapping.
  static ConfigNode Load(const std::filesystem::path& path);
  // `name` stands for the file in messages.
  static ConfigNode Parse(const std::string& text, const std::string& name);

  bool Has(std::string_view key) const;
  std::vector<std::string> Keys() const;

  ConfigNode Map(std::string_view key) const;  // required
  std::vector<ConfigNode> MapList(std::string_view key) const;
  double Number(std::string_view key, Range range = Range::Any()) const;
  double NumberOr(std::string_view key, double fallback, Range range = Range::Any()) const;
  int Integer(std::string_view key, int min = std::numeric_limits<int>::min(),
              int max = std::numeric_limits<int>::max()) const;
  int IntegerOr(std::string_view key, int fallback, int min = std::numeric_limits<int>::min(),
                int max = std::numeric_limits<int>::max()) const;
  bool BoolOr(std::string_view key, bool fallback) const;
  std::string Text(std::string_view key) const;
  std::string TextOr(std::string_view key, std::string fallback) const;
  // One of `names`, else the message lists them.
  std::string Choice(std::string_view key, const std::vector<std::string>& names) const;
  // A list of words, which may be empty.
  std::vector<std::string> Texts(std::string_view key) const;
  // A list of exactly `size` numbers (0: any length, but not empty).
  std::vector<double> Numbers(std::string_view key, std::size_t size = 0,
                              Range range = Range::Any()) const;

  // Throws if this mapping, or any mapping below it that was opened, holds a key never read.
  void RefuseUnknownKeys() const;

  // Throws ConfigError at this key: for what only the caller can judge.
  [[noreturn]] void Fail(std::string_view key, const std::string& complaint) const;

  // "rig.yaml:14: axes.tilt": where this mapping is, for what turns out to be wrong later.
  std::string Where() const;

  const std::string& file() const;

 private:
  struct Impl;
  explicit ConfigNode(std::shared_ptr<Impl> impl);

  std::shared_ptr<Impl> impl_;
};

}  // namespace gonio
