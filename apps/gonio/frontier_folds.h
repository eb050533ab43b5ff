// SPDX-License-Identifier: Apache-2.0
// Who is learned from and who is scored: the wall between training and test.

#pragma once

#include <filesystem>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "apps/gonio/frontier_config.h"
#include "fitting/pca_reflectance.h"
#include "fitting/prior.h"

namespace gonio {

enum class Role { kScored, kHeldOut, kExtra };

struct FrontierMaterial {
  std::filesystem::path path;
  std::string name;  // the file's without extension; no two are alike
  std::string hash;  // SHA-256 of the file
  Role role = Role::kScored;
  // The i-th scored material in alphabetical order is in fold i % folds. Materials held out are in
  // a fold of their own, number `folds`; extra ones in none, -1.
  int fold = -1;
};

// Opens nothing but reads every file once. Throws ConfigError: more folds than materials, two
// materials of the same name, two files with the same content (a copy would be learned from and
// scored), a file that cannot be read.
std::vector<FrontierMaterial> FindFrontierMaterials(
    const FrontierConfig& study, const std::filesystem::path& study_file,
    const std::vector<std::filesystem::path>& folders, int threads);

// Throws ConfigError "MATERIAL: PRIOR has seen it ..." if `prior`, or the file it was learned from,
// lists the material by name or one of `training_hashes` is its content.
void RefuseSeen(const FrontierMaterial& material, const Prior& prior,
                const std::vector<std::string>& training_hashes);

// What is known before a material of this fold is measured: learned from the other folds and the
// extra files.
struct Knowledge {
  Prior prior;
  std::shared_ptr<const PcaBasis> pca;  // if a contestant needs it
  std::vector<std::string> hashes;      // of the files it was learned from
};

// Learns a fold's knowledge, keeps it in `dir`/priors and reads it back; principal components are
// too large to keep and computed when they are first asked for. Many threads.
class Fold {
 public:
  // `users`: how often Done() will be called; the knowledge is dropped from memory by the last.
  // `with_pca`: one of them needs principal components.
  Fold(int number, const std::vector<FrontierMaterial>& materials, std::filesystem::path dir,
       int users, bool with_pca);

  // Whatever the knowledge depends on.
  const std::string& key() const { return key_; }
  // Whether it had been learned before. Throws ConfigError as LearnPrior does.
  bool Learn();
  // Reads it unless it is in memory. Precondition: Learn() has not thrown.
  std::shared_ptr<const Knowledge> Get();
  void Done();

 private:
  std::filesystem::path PriorFile() const;
  std::filesystem::path RecordFile() const;
  bool IsLearned() const;

  const int number_;
  const std::filesystem::path dir_;
  std::vector<FrontierMaterial> training_;
  std::string key_;
  std::mutex mutex_;
  std::shared_ptr<const Knowledge> knowledge_;
  int users_;
  const bool with_pca_;
};

}  // namespace gonio
