// SPDX-License-Identifier: Apache-2.0
#include "apps/gonio/study_run.h"

#include <fmt/format.h>

#include <atomic>
#include <mutex>
#include <optional>

#include "apps/gonio/tabulate.h"
#include "brdf/metrics.h"
#include "brdf/open.h"
#include "core/sha256.h"
#include "core/task_pool.h"

namespace gonio {
namespace {

// Part of every key: to be raised when the same task gives other numbers than before.
constexpr int kNumbersVersion = 1;

// One material, read when its first task begins and dropped when its last one is done.
class Material {
 public:
  Material(std::filesystem::path path, int tasks) : path_(std::move(path)), left_(tasks) {}

  std::string name() const { return path_.stem().string(); }

  // Throws ConfigError, each time it is asked, if the file cannot be read.
  const std::string& hash() {
    const std::lock_guard lock(mutex_);
    if (hash_.empty()) hash_ = Sha256OfFile(path_);
    return hash_;
  }
  MerlTable table() {
    const std::lock_guard lock(mutex_);
    if (!table_) table_ = Tabulate(*OpenBrdf(path_));
    return *table_;
  }
  void Done() {
    const std::lock_guard lock(mutex_);
    if (--left_ == 0) table_.reset();
  }

 private:
  std::filesystem::path path_;
  std::mutex mutex_;
  std::string hash_;
  std::optional<MerlTable> table_;
  int left_;
};

struct Task {
  Material* material = nullptr;
  FitMethod method = FitMethod::kJoint;
  int keep_every = 1;
  std::vector<StudyCell> cells;
  bool done = false;
};

class Run {
 public:
  Run(const StudyConfig& study, const std::vector<std::filesystem::path>& materials,
      std::filesystem::path dir, ProgressLine& line, std::stop_token stop)
      : study_(study), dir_(std::move(dir)), line_(line), stop_(std::move(stop)) {
    const auto each = static_cast<int>(study.methods.size() * study.keep_every.size());
    for (const std::filesystem::path& path : materials) {
      materials_.push_back(std::make_unique<Material>(path, each));
      for (const FitMethod method : study.methods) {
        for (const int every : study.keep_every) {
          tasks_.push_back({materials_.back().get(), method, every, {}});
        }
      }
    }
  }

  StudyResult Do(int threads, StudyProgress* progress) {
    ForEachTask(tasks_.size(), threads, stop_, [this](std::size_t i) {
      DoTask(tasks_[i]);
      tasks_[i].material->Done();
      Show(tasks_[i]);
    });
    line_.Finish();
    StudyResult result{.name = study_.name, .cells = {}};
    progress->tasks = static_cast<int>(tasks_.size());
    progress->reused = reused_;
    for (Task& task : tasks_) {
      progress->whole = progress->whole && task.done;
      result.cells.insert(result.cells.end(), task.cells.begin(), task.cells.end());
    }
    return result;
  }

 private:
  void Show(const Task& task) {
    const std::lock_guard lock(mutex_);
    ++finished_;
    line_.Show(finished_, static_cast<int>(tasks_.size()),
               fmt::format("{} of {} fits, {} {}", finished_, tasks_.size(), task.material->name(),
                           NameOf(task.method)));
  }

  // What the numbers of a task depend on.
  std::string Key(const Task& task) const {
    std::string colours;
    for (const bool colour : study_.colours) colours += colour ? '1' : '0';
    return Sha256(fmt::format("{} {} {} {} {} {} {} {}", kNumbersVersion, task.material->hash(),
                              NameOf(task.method), task.keep_every, colours, study_.lobes,
                              study_.slice_step, study_.phi_stride));
  }

  void DoTask(Task& task) {
    const std::filesystem::path file =
        dir_ / "cells" / task.material->name() /
        fmt::format("{}-{}.json", NameOf(task.method), task.keep_every);
    std::string key;
    try {
      key = Key(task);
      if (auto cells = ReadCells(file, key)) {
        task.cells = std::move(*cells);
        task.done = true;
        ++reused_;
        return;
      }
      task.cells = Fit(task);
    } catch (const std::exception& e) {
      task.cells = Cells(task);
      for (StudyCell& cell : task.cells) cell.failure = e.what();
    }
    // A material that could not be read has no key: it is tried again next time.
    if (!key.empty()) WriteCells(file, key, task.cells);
    task.done = true;
  }

  // Empty cells, one for each colour of the study.
  std::vector<StudyCell> Cells(const Task& task) const {
    std::vector<StudyCell> cells;
    for (int c = 0; c < kChannels; ++c) {
      if (!study_.colours[c]) continue;
      StudyCell cell;
      cell.material = task.material->name();
      cell.method = NameOf(task.method);
      cell.keep_every = task.keep_every;
      cell.channel = c;
      cells.push_back(std::move(cell));
    }
    return cells;
  }

  std::vector<StudyCell> Fit(const Task& task) const {
    TableFitOptions options;
    options.method = task.method;
    options.lobes = study_.lobes;
    options.channels = study_.colours;
    options.slices.step = study_.slice_step;
    options.slices.keep_every = task.keep_every;
    const MerlTable table = task.material->table();
    const TableFit fit = FitTable(table, options);
    std::vector<StudyCell> cells = Cells(task);
    if (fit.model) Measure(table, *fit.model, &cells);
    for (StudyCell& cell : cells) {
      for (const ChannelFailure& warning : fit.warnings) {
        if (warning.channel == cell.channel) cell.warning = warning.reason;
      }
      for (const ChannelFailure& failure : fit.failures) {
        if (failure.channel == cell.channel) cell.failure = failure.reason;
      }
    }
    return cells;
  }

  void Measure(const MerlTable& table, const LobeModel& model,
               std::vector<StudyCell>* cells) const {
    MetricOptions options;
    options.phi_stride = study_.phi_stride;
    const ErrorMetrics m = Compare(table, model, options);
    for (StudyCell& cell : *cells) {
      const int c = cell.channel;
      cell.male = m.male_per_channel[c];
      cell.table_mse = m.table_mse_per_channel[c];
      cell.mse = m.mse_per_channel[c];
      cell.log_relative_rms = m.log_relative_rms_per_channel[c];
      cell.cube_root_rms = m.cube_root_rms_per_channel[c];
      cell.log_mse = m.log_mse_per_channel[c];
    }
  }

  const StudyConfig& study_;
  std::filesystem::path dir_;
  ProgressLine& line_;
  std::stop_token stop_;
  std::vector<std::unique_ptr<Material>> materials_;
  std::vector<Task> tasks_;
  std::atomic<int> reused_ = 0;
  std::mutex mutex_;  // of what follows
  int finished_ = 0;
};

}  // namespace

StudyResult RunStudy(const StudyConfig& study, const std::vector<std::filesystem::path>& materials,
                     const std::filesystem::path& dir, int threads, ProgressLine& line,
                     const std::stop_token& stop, StudyProgress* progress) {
  return Run(study, materials, dir, line, stop).Do(threads, progress);
}

}  // namespace gonio
