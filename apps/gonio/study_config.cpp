// SPDX-License-Identifier: Apache-2.0
#include "apps/gonio/study_config.h"

#include <fmt/format.h>
#include <fnmatch.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "apps/gonio/locate.h"
#include "brdf/merl_table.h"
#include "core/config.h"
#include "core/error.h"
#include "core/file.h"

namespace gonio {
namespace {

std::vector<int> ReadThinnings(const ConfigNode& node) {
  std::vector<int> thinnings;
  for (const double number : node.Numbers("keep_every", 0, Range::Between(1, MerlTable::kThetaH))) {
    if (number != std::floor(number)) node.Fail("keep_every", "must hold whole numbers");
    const int every = static_cast<int>(number);
    if (std::find(thinnings.begin(), thinnings.end(), every) != thinnings.end()) {
      node.Fail("keep_every", fmt::format("holds {} twice", every));
    }
    thinnings.push_back(every);
  }
  return thinnings;
}

// A list of words out of `allowed`, each once.
std::vector<std::string> ReadWords(const ConfigNode& node, const char* key,
                                   const std::vector<std::string>& allowed) {
  const std::vector<std::string> words = node.Texts(key);
  if (words.empty()) node.Fail(key, "is empty");
  std::set<std::string> seen;
  for (const std::string& word : words) {
    if (std::find(allowed.begin(), allowed.end(), word) == allowed.end()) {
      std::string list;
      for (const std::string& name : allowed) list += (list.empty() ? "" : ", ") + name;
      node.Fail(key, fmt::format("holds \"{}\", must be of {}", word, list));
    }
    if (!seen.insert(word).second) node.Fail(key, fmt::format("holds \"{}\" twice", word));
  }
  return words;
}

StudyMontage ReadMontage(const ConfigNode& node) {
  StudyMontage montage;
  montage.materials = node.Texts("materials");
  montage.keep_every = ReadThinnings(node);
  montage.method = FitMethodFromName(node.Choice("method", {"em", "joint", "continuous"}));
  montage.lights = ReadWords(node, "lights", {"point", "env"});
  return montage;
}

// The files in `folder` that a pattern stands for, by name.
std::vector<std::filesystem::path> Matches(const std::filesystem::path& folder,
                                           const std::string& pattern) {
  std::vector<std::filesystem::path> matches;
  std::error_code ignored;
  for (const auto& entry : std::filesystem::directory_iterator(folder, ignored)) {
    if (fnmatch(pattern.c_str(), entry.path().filename().c_str(), 0) == 0) {
      matches.push_back(entry.path());
    }
  }
  std::sort(matches.begin(), matches.end());
  return matches;
}

// Where materials are looked for.
std::vector<std::filesystem::path> Places(const std::filesystem::path& study_file,
                                          const std::vector<std::filesystem::path>& folders) {
  for (const std::filesystem::path& place : folders) {
    if (!std::filesystem::is_directory(place)) {
      throw ConfigError(place.string() + ": no such directory");
    }
  }
  if (!folders.empty()) return folders;
  const std::filesystem::path own = study_file.parent_path();
  return {own.empty() ? "." : own, ConfigDir() / "materials"};
}

}  // namespace

StudyKind KindOfStudy(const std::filesystem::path& path) {
  const ConfigNode root = ConfigNode::Load(path);
  return root.Has("kind") && root.Choice("kind", {"thinning", "frontier"}) == "frontier"
             ? StudyKind::kFrontier
             : StudyKind::kThinning;
}

StudyConfig LoadStudy(const std::filesystem::path& path) {
  const ConfigNode root = ConfigNode::Load(path);
  if (root.Has("kind")) root.Choice("kind", {"thinning"});
  root.Integer("version", 1, 1);
  StudyConfig study;
  study.name = root.Text("name");
  study.materials = root.Texts("materials");
  if (study.materials.empty()) root.Fail("materials", "is empty");
  for (const std::string& method : ReadWords(root, "methods", {"em", "joint", "continuous"})) {
    study.methods.push_back(FitMethodFromName(method));
  }
  study.keep_every = ReadThinnings(root);
  if (root.Has("colours")) {
    study.colours.fill(false);
    const std::vector<std::string> names(std::begin(kChannelNames), std::end(kChannelNames));
    for (const std::string& colour : ReadWords(root, "colours", names)) {
      study.colours[std::find(names.begin(), names.end(), colour) - names.begin()] = true;
    }
  }
  study.lobes = root.IntegerOr("lobes", study.lobes, 1, kMaxLobes);
  study.slice_step = RadFromDeg(root.NumberOr("slice_step_deg", 5, Range::Between(1, 30)));
  study.phi_stride = root.IntegerOr("phi_stride", 1, 1, MerlTable::kPhiD);
  if (root.Has("montage")) study.montage = ReadMontage(root.Map("montage"));
  root.RefuseUnknownKeys();
  return study;
}

std::vector<std::filesystem::path> FindFiles(const std::vector<std::string>& patterns,
                                             const std::string& key,
                                             const std::filesystem::path& study_file,
                                             const std::vector<std::filesystem::path>& folders) {
  const std::vector<std::filesystem::path> places = Places(study_file, folders);
  std::vector<std::filesystem::path> files;
  std::map<std::string, std::filesystem::path> by_stem;
  for (const std::string& pattern : patterns) {
    bool found = false;
    for (const std::filesystem::path& place : places) {
      for (const std::filesystem::path& file : Matches(place, pattern)) {
        found = true;
        const auto [other, fresh] = by_stem.emplace(file.stem().string(), file);
        if (fresh) files.push_back(file);
        if (!fresh && other->second != file) {
          throw ConfigError(
              fmt::format("{}: has the same name as {}", file.string(), other->second.string()));
        }
      }
    }
    // A pattern may stand for nothing, a name may not.
    if (!found && pattern.find_first_of("*?[") == std::string::npos) {
      throw ConfigError(fmt::format("{}: {}: nothing is called \"{}\" in {}", study_file.string(),
                                    key, pattern, places.front().string()));
    }
  }
  return files;
}

std::vector<std::filesystem::path> FindMaterials(
    const std::vector<std::string>& patterns, const std::filesystem::path& study_file,
    const std::vector<std::filesystem::path>& folders) {
  std::vector<std::filesystem::path> files = FindFiles(patterns, "materials", study_file, folders);
  if (files.empty()) {
    throw ConfigError(
        fmt::format("{}: materials: none found in {}; --materials names other folders",
                    study_file.string(), Places(study_file, folders).front().string()));
  }
  return files;
}

void KeepStudyFile(const std::filesystem::path& study, const std::filesystem::path& dir) {
  const std::string text = ReadTextFile(study);
  WriteFileAtomically(dir / "study.yaml", [&](std::ostream& out) { out << text; });
}

}  // namespace gonio
