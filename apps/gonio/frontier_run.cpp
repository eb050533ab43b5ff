// SPDX-License-Identifier: Apache-2.0
#include "apps/gonio/frontier_run.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <atomic>
#include <map>
#include <mutex>

#include "acquisition/time_estimate.h"
#include "apps/gonio/frontier_session.h"
#include "apps/gonio/open_any.h"
#include "apps/gonio/tabulate.h"
#include "brdf/metrics.h"
#include "brdf/open.h"
#include "core/sha256.h"
#include "core/task_pool.h"

namespace gonio {
namespace {

// Part of every key: to be raised when the same task gives other numbers than before.
constexpr int kNumbersVersion = 3;
constexpr double kThinnedShare = 0.3;  // of the theta_h rows: the published decimation

struct Task {
  const FrontierMaterial* material = nullptr;
  const Contestant* contestant = nullptr;
  std::string noise;
  std::uint64_t seed = 1;
  FrontierCell cell{};
  bool done = false;
};

class Run {
 public:
  Run(const FrontierConfig& study, const std::vector<FrontierMaterial>& materials,
      std::filesystem::path dir, ProgressLine& line, FrontierStopTokens stop)
      : study_(study), dir_(std::move(dir)), line_(line), stop_(std::move(stop)) {
    rigs_["default"] = study.rig;
    rigs_["none"] = WithoutNoise(study.rig);
    for (const FrontierMaterial& material : materials) {
      if (material.role != Role::kExtra) AddTasks(material);
    }
    AddFolds(materials);
    RefuseSeenByPlans();
  }

  FrontierResult Do(int threads, StudyProgress* progress) {
    ForEachTask(folds_.size() + scored_.size(), threads, stop_.after_task, [this](std::size_t i) {
      i < folds_.size() ? Learn(i) : FitDense(i - folds_.size());
    });
    ForEachTask(tasks_.size(), threads, stop_.after_task, [this](std::size_t i) { DoTask(i); });
    line_.Finish();
    FrontierResult result = Describe();
    progress->tasks = Total();
    progress->reused = reused_;
    progress->whole = finished_ == Total();
    for (std::size_t i = 0; i < dense_.size(); ++i) {
      if (dense_done_[i]) result.dense.push_back(dense_[i]);
    }
    for (Task& task : tasks_) {
      if (task.done) result.cells.push_back(std::move(task.cell));
    }
    return result;
  }

 private:
  int Total() const { return static_cast<int>(folds_.size() + scored_.size() + tasks_.size()); }

  void AddTasks(const FrontierMaterial& material) {
    scored_.push_back(&material);
    dense_.push_back(
        {.material = material.name, .held_out = material.role == Role::kHeldOut, .failure = {}});
    dense_done_.push_back(0);
    for (const Contestant& contestant : study_.contestants) {
      for (const std::string& noise : study_.noises) {
        for (const std::uint64_t seed : study_.seeds) {
          tasks_.push_back({&material, &contestant, noise, seed});
        }
      }
    }
  }

  // Only folds that somebody needs.
  void AddFolds(const std::vector<FrontierMaterial>& materials) {
    std::map<int, int> users;
    bool with_pca = false;
    for (const Task& task : tasks_) {
      if (task.contestant->IsTaught()) ++users[task.material->fold];
      with_pca = with_pca || task.contestant->NeedsPca();
    }
    for (const auto& [number, count] : users) {
      fold_index_[number] = folds_.size();
      folds_.push_back(std::make_unique<Fold>(number, materials, dir_, count, with_pca));
      fold_failures_.emplace_back();
    }
  }

  void RefuseSeenByPlans() const {
    for (const Task& task : tasks_) {
      if (!task.contestant->learned_prior) {
        RefuseSeen(*task.material, task.contestant->plan.prior, {});
      }
    }
  }

  FrontierResult Describe() const {
    const RigConfig& rig = study_.rig.config;
    const TimeEstimate dense = EstimateDenseScan(rig, NominalExposing(rig));
    const TimeEstimate thinned = EstimateDenseScan(rig, NominalExposing(rig), kThinnedShare);
    return {.name = study_.name,
            .rig = rig.name,
            .dense_method = std::string(NameOf(study_.dense)),
            .dense_hours = dense.total().count() / 3600,
            .thinned_hours = thinned.total().count() / 3600,
            .dense_poses = dense.poses,
            .thinned_poses = thinned.poses,
            .dense = {},
            .cells = {}};
  }

  void Finished(bool reused, const std::string& what) {
    const std::lock_guard lock(mutex_);
    reused_ += reused ? 1 : 0;
    ++finished_;
    line_.Show(finished_, Total(), fmt::format("{} of {} tasks, {}", finished_, Total(), what));
  }

  void Learn(std::size_t i) {
    bool reused = false;
    try {
      reused = folds_[i]->Learn();
    } catch (const ConfigError& e) {
      fold_failures_[i] = fmt::format("nothing could be learned: {}", e.what());
    }
    Finished(reused, "learning");
  }

  void FitDense(std::size_t i) {
    const FrontierMaterial& material = *scored_[i];
    const auto file = dir_ / "cells" / material.name / "dense.json";
    const std::string key =
        Sha256(fmt::format("{} {} {} {} {}", kNumbersVersion, material.hash, NameOf(study_.dense),
                           study_.theta_d_stride, study_.phi_stride));
    DenseCell& cell = dense_[i];
    const auto before = ReadDenseCell(file, key);
    if (before) {
      cell = *before;
      cell.held_out = material.role == Role::kHeldOut;
    } else {
      try {
        const MerlTable table = Tabulate(*OpenBrdf(material.path));
        TableFitOptions options;
        options.method = study_.dense;
        const TableFit fit = FitTable(table, options);
        if (!fit.failures.empty()) throw ConfigError(fit.failures.front().reason);
        cell.male = Compare(table, *fit.model, study_.Metrics()).male;
      } catch (const std::exception& e) {
        cell.failure = e.what();
      }
      WriteDenseCell(file, key, cell);
    }
    dense_done_[i] = 1;
    Finished(before.has_value(), material.name + " dense");
  }

  // What the numbers of a task depend on.
  std::string Key(const Task& task) const {
    const Contestant& c = *task.contestant;
    std::string prior = c.learned_prior ? "" : HashOf(c.plan.prior);
    if (c.IsTaught()) prior += folds_[fold_index_.at(task.material->fold)]->key();
    return Sha256(fmt::format("{}\n{}\n{}\n{}\n{}\n{}\n{} {} {}\n{}\n{}\n{} {}", kNumbersVersion,
                              task.material->hash, prior, c.plan.text, study_.rig.config.text,
                              NameOf(c.reconstruction), c.per_budget, task.noise, task.seed,
                              fmt::join(study_.budgets, ","), fmt::join(study_.targets, ","),
                              study_.theta_d_stride, study_.phi_stride));
  }

  void DoTask(std::size_t i) {
    Task& task = tasks_[i];
    const Contestant& contestant = *task.contestant;
    const auto file = dir_ / "cells" / task.material->name /
                      fmt::format("{}-{}-{}.json", contestant.name, task.noise, task.seed);
    const std::string key = Key(task);
    Fold* fold =
        contestant.IsTaught() ? folds_[fold_index_.at(task.material->fold)].get() : nullptr;
    auto before = ReadFrontierCell(file, key);
    if (before) task.cell = std::move(*before);
    const bool whole = before || Measure(fold, &task);
    if (fold != nullptr) fold->Done();
    if (!whole) return;
    task.cell.fold = task.material->fold;
    task.cell.held_out = task.material->role == Role::kHeldOut;
    if (!before) WriteFrontierCell(file, key, task.cell);
    task.done = true;
    Finished(before.has_value(), fmt::format("{} on {}", contestant.name, task.material->name));
  }

  // false: stopped. Failures are kept: the same task would fail again.
  bool Measure(Fold* fold, Task* task) {
    FrontierCell& cell = task->cell;
    cell = {.material = task->material->name,
            .contestant = task->contestant->name,
            .noise = task->noise,
            .seed = task->seed,
            .fold = task->material->fold};
    try {
      std::shared_ptr<const Knowledge> learned;
      if (fold != nullptr) {
        const std::string& failure = fold_failures_[fold_index_.at(task->material->fold)];
        if (!failure.empty()) throw ConfigError(failure);
        learned = fold->Get();
      }
      return RunFrontierSession({study_, rigs_.at(task->noise), *task->material, *task->contestant,
                                 learned.get(), task->seed},
                                stop_.now, &cell);
    } catch (const std::exception& e) {
      cell.failure = e.what();
      cell.rows.clear();
      for (const int budget : study_.budgets) {
        cell.rows.push_back({.budget = budget, .failure = cell.failure});
      }
      return true;
    }
  }

  const FrontierConfig& study_;
  const std::filesystem::path dir_;
  ProgressLine& line_;
  const FrontierStopTokens stop_;
  std::map<std::string, RigFile> rigs_;  // by noise
  std::vector<const FrontierMaterial*> scored_;
  std::vector<DenseCell> dense_;
  std::vector<char> dense_done_;  // not bool: neighbours are written by different threads
  std::vector<std::unique_ptr<Fold>> folds_;
  std::map<int, std::size_t> fold_index_;  // by number
  std::vector<std::string> fold_failures_;
  std::vector<Task> tasks_;
  std::mutex mutex_;  // of what follows
  int finished_ = 0;
  int reused_ = 0;
};

}  // namespace

FrontierResult RunFrontier(const FrontierConfig& study,
                           const std::vector<FrontierMaterial>& materials,
                           const std::filesystem::path& dir, int threads, ProgressLine& line,
                           const FrontierStopTokens& stop, StudyProgress* progress) {
  return Run(study, materials, dir, line, stop).Do(threads, progress);
}

}  // namespace gonio
