// SPDX-License-Identifier: Apache-2.0
#include "apps/gonio/frontier_folds.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <nlohmann/json.hpp>

#include "apps/gonio/frontier_learning.h"
#include "apps/gonio/json_file.h"
#include "apps/gonio/study_config.h"
#include "core/error.h"
#include "core/file.h"
#include "core/sha256.h"
#include "core/task_pool.h"

namespace gonio {
namespace {

using nlohmann::json;

// Part of a fold's key: to be raised when the same materials teach something else than before.
constexpr int kLearningVersion = 3;

std::vector<FrontierMaterial> ToMaterials(const std::vector<std::filesystem::path>& paths,
                                          Role role) {
  std::vector<FrontierMaterial> materials;
  for (const std::filesystem::path& path : paths) {
    materials.push_back({.path = path, .name = path.stem().string(), .hash = {}, .role = role});
  }
  std::sort(materials.begin(), materials.end(),
            [](const FrontierMaterial& a, const FrontierMaterial& b) { return a.name < b.name; });
  return materials;
}

void RefuseTwins(const std::vector<FrontierMaterial>& materials) {
  std::map<std::string, const FrontierMaterial*> by_name, by_hash;
  for (const FrontierMaterial& material : materials) {
    const auto [name, new_name] = by_name.emplace(material.name, &material);
    if (!new_name) {
      throw ConfigError(
          fmt::format("{}: has the same name as {}: a material is either scored, or "
                      "held out, or extra training",
                      material.path.string(), name->second->path.string()));
    }
    const auto [hash, new_hash] = by_hash.emplace(material.hash, &material);
    if (!new_hash) {
      throw ConfigError(
          fmt::format("{}: has the same content as {}: one would be scored with what "
                      "the other taught",
                      material.path.string(), hash->second->path.string()));
    }
  }
}

}  // namespace

std::vector<FrontierMaterial> FindFrontierMaterials(
    const FrontierConfig& study, const std::filesystem::path& study_file,
    const std::vector<std::filesystem::path>& folders, int threads) {
  const auto find = [&](const std::vector<std::string>& patterns, const char* key, Role role) {
    return ToMaterials(FindFiles(patterns, key, study_file, folders), role);
  };
  std::vector<FrontierMaterial> materials =
      ToMaterials(FindMaterials(study.materials, study_file, folders), Role::kScored);
  if (study.folds > static_cast<int>(materials.size())) {
    throw ConfigError(fmt::format("{}: folds: is {}, but there are only {} materials",
                                  study_file.string(), study.folds, materials.size()));
  }
  for (std::size_t i = 0; i < materials.size(); ++i) {
    materials[i].fold = static_cast<int>(i) % study.folds;
  }
  for (FrontierMaterial& material : find(study.held_out, "held_out", Role::kHeldOut)) {
    materials.push_back(std::move(material));
    materials.back().fold = study.folds;
  }
  for (FrontierMaterial& material : find(study.extra_training, "extra_training", Role::kExtra)) {
    materials.push_back(std::move(material));
  }
  ForEachTask(materials.size(), threads, {},
              [&](std::size_t i) { materials[i].hash = Sha256OfFile(materials[i].path); });
  RefuseTwins(materials);
  return materials;
}

void RefuseSeen(const FrontierMaterial& material, const Prior& prior,
                const std::vector<std::string>& training_hashes) {
  if (HasSeen(prior, material.name)) {
    throw ConfigError(
        fmt::format("{}: the prior \"{}\" has seen it: it lists it among the "
                    "materials it was learned from",
                    material.name, prior.name));
  }
  if (std::find(training_hashes.begin(), training_hashes.end(), material.hash) !=
      training_hashes.end()) {
    throw ConfigError(
        fmt::format("{}: the prior \"{}\" has seen it: it was learned from a file "
                    "with the same content",
                    material.name, prior.name));
  }
}

Fold::Fold(int number, const std::vector<FrontierMaterial>& materials, std::filesystem::path dir,
           int users, bool with_pca)
    : number_(number), dir_(std::move(dir)), users_(users), with_pca_(with_pca) {
  std::string hashed = fmt::format("{}", kLearningVersion);
  for (const FrontierMaterial& material : materials) {
    if (material.role == Role::kHeldOut || material.fold == number) continue;
    training_.push_back(material);
    hashed += fmt::format(" {} {}", material.name, material.hash);
  }
  key_ = Sha256(hashed);
}

std::filesystem::path Fold::PriorFile() const {
  return dir_ / "priors" / fmt::format("fold-{}.yaml", number_);
}

std::filesystem::path Fold::RecordFile() const {
  return dir_ / "priors" / fmt::format("fold-{}.json", number_);
}

bool Fold::IsLearned() const {
  if (!std::filesystem::exists(RecordFile()) || !std::filesystem::exists(PriorFile())) return false;
  try {
    const json record = json::parse(ReadTextFile(RecordFile()));
    return record.at("key") == key_ && record.at("prior_sha256") == Sha256OfFile(PriorFile());
  } catch (const std::exception&) {
    return false;  // torn: learned again
  }
}

bool Fold::Learn() {
  if (IsLearned()) return true;
  std::filesystem::create_directories(dir_ / "priors");
  WritePrior(PriorFile(), LearnFrom(training_, fmt::format("fold {}", number_)));
  json materials = json::array();
  for (const FrontierMaterial& material : training_) {
    materials.push_back({{"name", material.name}, {"sha256", material.hash}});
  }
  // Last: a record stands for a prior that is whole.
  WriteJson(RecordFile(),
            {{"key", key_}, {"prior_sha256", Sha256OfFile(PriorFile())}, {"materials", materials}});
  return false;
}

std::shared_ptr<const Knowledge> Fold::Get() {
  const std::lock_guard lock(mutex_);
  if (!knowledge_) {
    auto knowledge = std::make_shared<Knowledge>();
    knowledge->prior = ReadPrior(PriorFile());
    for (const FrontierMaterial& material : training_) knowledge->hashes.push_back(material.hash);
    if (with_pca_) knowledge->pca = LearnPca(training_);
    knowledge_ = knowledge;
  }
  return knowledge_;
}

void Fold::Done() {
  const std::lock_guard lock(mutex_);
  if (--users_ == 0) knowledge_.reset();
}

}  // namespace gonio
