// SPDX-License-Identifier: Apache-2.0
// gonio run --resume: a session goes on after whatever ended it.

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <utility>

#include "acquisition/radiometry.h"
#include "acquisition/rereduction.h"
#include "acquisition/session_check.h"
#include "acquisition/session_history.h"
#include "acquisition/wal_tail.h"
#include "apps/gonio/commands.h"
#include "apps/gonio/open_any.h"
#include "apps/gonio/session_drive.h"
#include "apps/gonio/session_setup.h"
#include "apps/gonio/text_difference.h"
#include "core/error.h"
#include "core/file.h"
#include "core/sha256.h"

namespace gonio {
namespace {

namespace fs = std::filesystem;

// A session as it was and as it would go on.
class Resumption {
 public:
  explicit Resumption(const RunOptions& options)
      : options_(options),
        dir_(options.resume),
        tail_(ReadWalTail(dir_ / (std::string(kSessionFile) + "-wal"))),
        log_(EventLog::Open(dir_)),
        record_(ReadSession(dir_)),
        was_(LatestInfo(record_)),
        now_(was_) {
    note_.gonio_version = GONIO_VERSION;
  }

  int Run() {
    if (!record_.info.imported.empty()) {
      throw ConfigError(dir_.string() + ": was imported: there is no rig to go on with");
    }
    WarnOfDroppedPages();
    if (record_.end && record_.end->outcome == "complete" && options_.max_poses == 0) {
      throw ConfigError(
          fmt::format("{}: is complete ({}); --max-poses with --accept-changed goes "
                      "on with a larger budget",
                      dir_.string(), record_.end->reason));
    }
    RefuseDamage();
    CompareFiles();
    RefuseChanges();
    SessionChoice choice = ChoiceOf(now_, dir_);
    setup_ = SetUp(choice);
    RefuseOtherAxes();
    CompareContents();
    RefuseChanges();
    CheckCopies();
    calibrations_ = LoadCopies(dir_ / kSessionCalibration);
    Believe(calibrations_, &setup_.rig.config);
    ReduceLast();
    const SessionHistory history = HistoryOf(record_);
    const std::unique_ptr<Planner> planner = PlannerFor(setup_, was_.seed);
    const SessionSoFar so_far = Follow(history, *planner);
    RefuseChanges();
    const DriveOptions drive = DriveOptionsOf(options_, setup_.rig.config);
    OpenedRig rig = Open(setup_, was_.seed, history.end);
    CompareDevices(rig.devices);
    RefuseChanges();
    Announce(rig, so_far);
    return DriveSession({setup_, rig, calibrations_, *planner, log_, was_.seed, &so_far}, drive,
                        dir_);
  }

 private:
  void WarnOfDroppedPages() const {
    if (tail_.damaged == 1) {
      fmt::print(
          stderr,
          "gonio: warning: {}: the last page of the write-ahead log is not whole: it was being "
          "written when the session broke off, or is damaged and the newest of what was written "
          "is lost; what is left is whole\n",
          dir_.string());
    } else if (tail_.damaged > 1) {
      fmt::print(stderr,
                 "gonio: warning: {}: the last {} pages of the write-ahead log are damaged, the "
                 "newest of what was written is lost; what is left is whole\n",
                 dir_.string(), tail_.damaged);
    }
  }

  void RefuseDamage() const {
    const std::vector<std::string> damage = FindDamage(dir_);
    if (damage.empty()) return;
    throw ConfigError(fmt::format("{}: is damaged: {}; gonio rescue keeps what is whole",
                                  dir_.string(), damage.front()));
  }

  // What was measured is kept as positions of the axes that the rig had.
  void RefuseOtherAxes() const {
    const auto axes = setup_.rig.config.axis_names();
    if (std::equal(axes.begin(), axes.end(), was_.axes.begin(), was_.axes.end())) return;
    throw ConfigError(fmt::format("{}: geometry.kind: has other axes than the session's: {}",
                                  was_.rig_path, fmt::join(was_.axes, ", ")));
  }

  // Notes a change; `key`: of `meta`, whose value is another from now on.
  void Change(std::string what, const std::string& key = {}, const std::string& value = {}) {
    note_.changes.push_back(std::move(what));
    if (!key.empty()) note_.now[key] = value;
  }

  void RefuseChanges() const {
    if (note_.changes.empty() || options_.accept_changed) return;
    for (const std::string& change : note_.changes) fmt::print(stderr, "{}\n", change);
    throw ConfigError(
        fmt::format("{}: not all is as it was when the session was begun; put it back, or go on "
                    "all the same with --accept-changed",
                    dir_.string()));
  }

  void CompareText(const std::string& path, const char* key, std::string* text) {
    if (path.empty() || !fs::exists(path)) return;  // then what was frozen is all there is
    std::string now = ReadTextFile(path);
    if (now == *text) return;
    std::string difference = TextDifference(*text, now);
    while (difference.ends_with('\n')) difference.pop_back();
    Change(fmt::format("{}:\n{}", path, difference), key, now);
    *text = std::move(now);
  }

  void CompareFiles() {
    CompareText(was_.rig_path, "rig_text", &now_.rig_text);
    CompareText(was_.plan_path, "plan_text", &now_.plan_text);
    if (options_.max_poses > 0 && options_.max_poses != was_.max_poses) {
      now_.max_poses = options_.max_poses;
      const std::string before =
          was_.max_poses > 0 ? std::to_string(was_.max_poses) : "as the plan has it";
      Change(fmt::format("budget of poses: was {}, is {}", before, now_.max_poses), "max_poses",
             std::to_string(now_.max_poses));
    }
  }

  void CompareHash(const std::string& what, const char* key, const std::string& before,
                   const std::string& now) {
    if (before == now) return;
    Change(fmt::format("{}: its SHA-256 was {}, is {}", what, before, now), key, now);
  }

  void CompareContents() {
    CompareHash("prior " + was_.prior_name, "prior_sha256", was_.prior_sha256,
                HashOf(setup_.plan.prior));
    if (was_.material_path.empty()) return;
    CompareHash(was_.material_path, "material_sha256", was_.material_sha256,
                HashOfMaterial(was_.material_path));
  }

  void CompareDevices(const Devices& devices) {
    const std::map<std::string, std::string> now = IdentitiesOf(devices);
    for (const auto& [role, identity] : now) {
      const auto before = was_.devices.find(role);
      if (before != was_.devices.end() && before->second == identity) continue;
      Change(fmt::format("{}: was {}, is {}", role,
                         before == was_.devices.end() ? "not there" : before->second, identity));
    }
  }

  // The session's own copies, which nobody has any business to change.
  void CheckCopies() const {
    for (const auto& [name, sha256] : was_.calibrations) {
      const fs::path file = dir_ / kSessionCalibration / name;
      if (fs::exists(file) && Sha256OfFile(file) == sha256) continue;
      throw ConfigError(file.string() + ": is not what the session was begun with");
    }
  }

  // A pose of which only the frames were kept is whole all the same.
  void ReduceLast() {
    if (!record_.unreduced) return;
    const MeasuredPose& pose = *record_.unreduced;
    const auto samples =
        Rereduction(dir_, setup_.rig.config, calibrations_, HistoryOf(record_).visits).Of(pose);
    if (!samples) throw std::runtime_error(samples.error().message);
    if (auto kept = log_.AppendSamples(pose.pose, pose.end, *samples); !kept) {
      throw std::runtime_error(kept.error().message);
    }
    record_ = ReadSession(dir_);
  }

  // Tells the planner of all that was measured.
  SessionSoFar Follow(const SessionHistory& history, Planner& planner) {
    RetraceOptions options;
    if (options_.accept_changed) {
      options.agree_from = static_cast<int>(history.turns.size());
      options.learn = IndexIn(CandidatesOf(setup_.plan, setup_.Measurable()));
    } else if (history.parts.size() > 1) {  // what an earlier resume was allowed to
      options.agree_from = history.parts.back().turn;
      options.learn = IndexIn(CandidatesOf(setup_.plan, setup_.Measurable()));
    }
    Retraced retraced = Retrace(record_, history, setup_.rig.config, planner, options);
    if (retraced.first) {
      Change(fmt::format("the planner decides otherwise: {}", retraced.first->what));
    }
    return std::move(retraced.so_far);
  }

  void Announce(const OpenedRig& rig, const SessionSoFar& so_far) {
    note_.poses = static_cast<int>(so_far.summary.poses.size());
    if (auto kept = log_.AppendResume(rig.clock->Now(), note_); !kept) {
      throw std::runtime_error(kept.error().message);
    }
    if (options_.quiet) return;
    fmt::print("going on with    {}: {} poses measured, {} refused\n", dir_.string(), note_.poses,
               so_far.summary.rejected);
  }

  const RunOptions& options_;
  const fs::path dir_;
  const WalTail tail_;  // before SQLite has dropped what is not whole
  EventLog log_;
  SessionRecord record_;
  const SessionInfo was_;
  SessionInfo now_;
  ResumeNote note_;
  SessionSetup setup_;
  Calibrations calibrations_;
};

}  // namespace

int ResumeSession(const RunOptions& options) { return Resumption(options).Run(); }

}  // namespace gonio
