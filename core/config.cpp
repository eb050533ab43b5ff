// SPDX-License-Identifier: Apache-2.0
#include "core/config.h"

#include <fmt/format.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

#include "core/error.h"
#include "core/file.h"

namespace gonio {

struct ConfigNode::Impl {
  std::string file;
  std::string path;  // "axes.tilt." or empty at the root
  YAML::Node node;
  std::set<std::string, std::less<>> read;
  std::map<std::string, std::vector<ConfigNode>, std::less<>> opened;

  [[noreturn]] void FailAt(const YAML::Mark& mark, std::string_view key,
                           const std::string& complaint) const {
    throw ConfigError(fmt::format("{}:{}: {}{}: {}", file, mark.line + 1, path, key, complaint));
  }

  // The value of `key`, or an undefined node.
  YAML::Node Find(std::string_view key) {
    read.emplace(key);
    for (const auto& entry : node) {
      if (entry.first.Scalar() == key) return entry.second;
    }
    return YAML::Node(YAML::NodeType::Undefined);
  }

  YAML::Node Require(std::string_view key) {
    YAML::Node found = Find(key);
    if (!found.IsDefined() || found.IsNull()) FailAt(node.Mark(), key, "is missing");
    return found;
  }

  std::string Scalar(std::string_view key) {
    const YAML::Node found = Require(key);
    if (!found.IsScalar()) FailAt(found.Mark(), key, "must be a single value");
    return found.Scalar();
  }
};

namespace {

std::string Describe(const Range& range) {
  const bool low = std::isfinite(range.min);
  const bool high = std::isfinite(range.max);
  if (low && high && range.min_open) {
    return fmt::format("must be > {} and <= {}", range.min, range.max);
  }
  if (low && high) return fmt::format("must be between {} and {}", range.min, range.max);
  if (low) return fmt::format("must be {} {}", range.min_open ? ">" : ">=", range.min);
  return fmt::format("must be <= {}", range.max);
}

bool Holds(const Range& range, double number) {
  return number <= range.max && (range.min_open ? number > range.min : number >= range.min);
}

// Throws on a key that stands twice in one mapping, which YAML forbids and yaml-cpp lets pass, and
// on an alias that contains itself, which no reader gets to the end of. `above`: the nodes around
// this one.
void RefuseTraps(const YAML::Node& node, const std::string& file, std::vector<YAML::Node>* above) {
  const auto fail = [&file](const YAML::Mark& mark, const std::string& complaint) {
    throw ConfigError(fmt::format("{}:{}: {}", file, mark.line + 1, complaint));
  };
  if (std::any_of(above->begin(), above->end(), [&](const auto& n) { return n.is(node); })) {
    fail(node.Mark(), "holds an alias that contains itself");
  }
  above->push_back(node);
  if (node.IsSequence()) {
    for (const auto& item : node) RefuseTraps(item, file, above);
  } else if (node.IsMap()) {
    std::set<std::string> seen;
    for (const auto& entry : node) {
      const YAML::Mark mark = entry.first.Mark();
      if (!entry.first.IsScalar()) fail(mark, "a key must be a single word");
      if (!seen.insert(entry.first.Scalar()).second) {
        fail(mark, entry.first.Scalar() + ": stands twice");
      }
      RefuseTraps(entry.second, file, above);
    }
  }
  above->pop_back();
}

YAML::Node ParseOneDocument(const std::string& text, const std::string& name) {
  std::vector<YAML::Node> documents;
  try {
    documents = YAML::LoadAll(text);
  } catch (const YAML::Exception& e) {
    throw ConfigError(fmt::format("{}:{}: not valid YAML: {}", name, e.mark.line + 1, e.msg));
  }
  if (documents.size() > 1) {
    throw ConfigError(fmt::format("{}:{}: must hold one YAML document, not {}", name,
                                  documents[1].Mark().line + 1, documents.size()));
  }
  return documents.empty() ? YAML::Node() : documents[0];
}

}  // namespace

std::string YamlQuoted(std::string_view text) {
  std::string quoted = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') quoted += '\\';
    quoted += c;
  }
  return quoted + '"';
}

ConfigNode::ConfigNode(std::shared_ptr<Impl> impl) : impl_(std::move(impl)) {}

ConfigNode ConfigNode::Load(const std::filesystem::path& path) {
  return Parse(ReadTextFile(path), path.string());
}

ConfigNode ConfigNode::Parse(const std::string& text, const std::string& name) {
  auto impl = std::make_shared<Impl>();
  impl->file = name;
  impl->node = ParseOneDocument(text, name);
  if (!impl->node.IsMap()) {
    throw ConfigError(fmt::format("{}:1: must hold keys and values (\"key: value\")", name));
  }
  std::vector<YAML::Node> above;
  RefuseTraps(impl->node, name, &above);
  return ConfigNode(impl);
}

bool ConfigNode::Has(std::string_view key) const { return impl_->Find(key).IsDefined(); }

std::vector<std::string> ConfigNode::Keys() const {
  std::vector<std::string> keys;
  for (const auto& entry : impl_->node) keys.push_back(entry.first.Scalar());
  return keys;
}

ConfigNode ConfigNode::Map(std::string_view key) const {
  const YAML::Node found = impl_->Require(key);
  if (!found.IsMap()) impl_->FailAt(found.Mark(), key, "must hold keys and values");
  auto& opened = impl_->opened[std::string(key)];
  if (opened.empty()) {
    auto child = std::make_shared<Impl>();
    child->file = impl_->file;
    child->path = fmt::format("{}{}.", impl_->path, key);
    child->node = found;
    opened.push_back(ConfigNode(child));
  }
  return opened.front();
}

std::vector<ConfigNode> ConfigNode::MapList(std::string_view key) const {
  const YAML::Node found = impl_->Require(key);
  if (!found.IsSequence() || found.size() == 0) {
    impl_->FailAt(found.Mark(), key, "must be a list that is not empty");
  }
  auto& opened = impl_->opened[std::string(key)];
  if (opened.empty()) {
    for (std::size_t i = 0; i < found.size(); ++i) {
      if (!found[i].IsMap())
        impl_->FailAt(found[i].Mark(), key, "entries must hold keys and values");
      auto child = std::make_shared<Impl>();
      child->file = impl_->file;
      child->path = fmt::format("{}{}[{}].", impl_->path, key, i);
      child->node = found[i];
      opened.push_back(ConfigNode(child));
    }
  }
  return opened;
}

double ConfigNode::Number(std::string_view key, Range range) const {
  const std::string text = impl_->Scalar(key);
  const YAML::Mark mark = impl_->Require(key).Mark();
  double number = 0;
  if (!YAML::convert<double>::decode(impl_->Require(key), number) || !std::isfinite(number)) {
    impl_->FailAt(mark, key, fmt::format("is \"{}\", must be a finite number", text));
  }
  if (!Holds(range, number)) {
    impl_->FailAt(mark, key, fmt::format("is {}, {}", text, Describe(range)));
  }
  return number;
}

double ConfigNode::NumberOr(std::string_view key, double fallback, Range range) const {
  return Has(key) ? Number(key, range) : fallback;
}

int ConfigNode::Integer(std::string_view key, int min, int max) const {
  Range range = Range::Between(min, max);
  if (max == std::numeric_limits<int>::max()) range.max = Range::Any().max;  // say ">= min" only
  const double number = Number(key, range);
  if (number > max) Fail(key, fmt::format("is {}, too large", number));
  if (number != std::floor(number)) Fail(key, fmt::format("is {}, must be a whole number", number));
  return static_cast<int>(number);
}

int ConfigNode::IntegerOr(std::string_view key, int fallback, int min, int max) const {
  return Has(key) ? Integer(key, min, max) : fallback;
}

bool ConfigNode::BoolOr(std::string_view key, bool fallback) const {
  if (!Has(key)) return fallback;
  const std::string text = impl_->Scalar(key);
  if (text == "true") return true;
  if (text == "false") return false;
  Fail(key, fmt::format("is \"{}\", must be true or false", text));
}

std::string ConfigNode::Text(std::string_view key) const {
  std::string text = impl_->Scalar(key);
  if (text.empty()) Fail(key, "must not be empty");
  return text;
}

std::string ConfigNode::TextOr(std::string_view key, std::string fallback) const {
  return Has(key) ? Text(key) : std::move(fallback);
}

std::string ConfigNode::Choice(std::string_view key, const std::vector<std::string>& names) const {
  std::string text = Text(key);
  if (std::find(names.begin(), names.end(), text) == names.end()) {
    Fail(key, fmt::format("is \"{}\", must be one of {}", text, fmt::join(names, ", ")));
  }
  return text;
}

std::vector<std::string> ConfigNode::Texts(std::string_view key) const {
  const YAML::Node found = impl_->Require(key);
  if (!found.IsSequence()) impl_->FailAt(found.Mark(), key, "must be a list");
  std::vector<std::string> texts;
  for (const auto& item : found) {
    if (!item.IsScalar()) impl_->FailAt(item.Mark(), key, "must be a list of words");
    texts.push_back(item.Scalar());
  }
  return texts;
}

std::vector<double> ConfigNode::Numbers(std::string_view key, std::size_t size, Range range) const {
  const YAML::Node found = impl_->Require(key);
  if (!found.IsSequence() || found.size() == 0 || (size != 0 && found.size() != size)) {
    impl_->FailAt(found.Mark(), key,
                  size == 0 ? "must be a list of numbers"
                            : fmt::format("must be a list of {} numbers", size));
  }
  std::vector<double> numbers;
  for (const auto& item : found) {
    double number = 0;
    if (!item.IsScalar() || !YAML::convert<double>::decode(item, number) ||
        !std::isfinite(number)) {
      impl_->FailAt(item.Mark(), key, "holds something that is not a finite number");
    }
    if (!Holds(range, number)) {
      impl_->FailAt(item.Mark(), key, fmt::format("holds {}, {}", number, Describe(range)));
    }
    numbers.push_back(number);
  }
  return numbers;
}

void ConfigNode::RefuseUnknownKeys() const {
  for (const auto& entry : impl_->node) {
    const std::string& key = entry.first.Scalar();
    if (!impl_->read.contains(key)) impl_->FailAt(entry.first.Mark(), key, "is not a known key");
  }
  for (const auto& [key, children] : impl_->opened) {
    for (const ConfigNode& child : children) child.RefuseUnknownKeys();
  }
}

void ConfigNode::Fail(std::string_view key, const std::string& complaint) const {
  const YAML::Node found = impl_->Find(key);
  impl_->FailAt(found.IsDefined() ? found.Mark() : impl_->node.Mark(), key, complaint);
}

std::string ConfigNode::Where() const {
  const std::string& path = impl_->path;
  return fmt::format("{}:{}{}{}", impl_->file, impl_->node.Mark().line + 1,
                     path.empty() ? "" : ": ", path.substr(0, path.find_last_of('.')));
}

const std::string& ConfigNode::file() const { return impl_->file; }

}  // namespace gonio
