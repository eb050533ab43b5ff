// SPDX-License-Identifier: Apache-2.0
#include "tests/campaign/campaign_session.h"

#include <fmt/format.h>

#include <cmath>
#include <cstdlib>

#include "acquisition/kinematics.h"
#include "acquisition/path_planner.h"
#include "acquisition/session_check.h"
#include "acquisition/session_history.h"
#include "acquisition/session_record.h"
#include "brdf/open.h"
#include "planner/plan.h"
#include "sim/random.h"
#include "tests/campaign/collision_watch.h"
#include "tests/core/temp_dir.h"
#include "tests/scenario/bench.h"
#include "tests/scenario/faulty_devices.h"

namespace gonio {
namespace {

constexpr const char* kSolidArms = "rig-solid-arms.yaml";

constexpr int kPoses = 20;
constexpr Seconds kTick{0.02};
constexpr Seconds kLongest{12 * 3600.0};
constexpr long kMostCalls = 200000;  // a session takes a few hundred
constexpr double kWrong = 6.5;       // sigmas: of some 40,000 readings none by chance
constexpr double kTouching = 0.004;  // m; the rig file keeps a margin of 10 mm

std::string ConfigPath(const std::string& name) {
  return std::string(GONIO_SOURCE_DIR) + "/configs/" + name;
}

// Time in which somebody looks at everything every 20 ms.
class TickingClock final : public Clock {
 public:
  explicit TickingClock(Seconds begin) : clock_(begin) {}
  Seconds Now() const override { return clock_.Now(); }
  void SleepFor(Seconds duration, std::stop_token stop) override {
    const Seconds end = Now() + duration;
    for (Seconds left = duration; left > Seconds(0); left = end - Now()) {
      if (stop.stop_requested()) return;
      clock_.SleepFor(std::min(left, kTick));
      if (on_tick) on_tick();
    }
  }
  std::function<void()> on_tick;

 private:
  ManualClock clock_;
};

// What a session is given, and what will go wrong.
struct Script {
  std::string rig;
  std::string plan;
  std::string material;
  FailuresConfig failures;
  double fault_rate = 0;  // of each call
  std::optional<Seconds> stop_after_pose, stop_now, pause;
  std::optional<TripAction> door;  // what it does when it opens,
  Seconds door_opens{0}, door_closes{0};
  double lamp_flicker = 0;
  Seconds lamp_fails_at{0};
  std::optional<rlim_t> disk;  // bytes
};

template <typename T>
const T& Pick(Random& random, const std::vector<T>& from) {
  return from[static_cast<std::size_t>(random.Uniform() * static_cast<double>(from.size()))];
}

FailurePolicy DrawPolicy(Random& random, int most_retries) {
  return {.retries = static_cast<int>(random.Uniform() * (most_retries + 1)),
          .wait = Seconds(5 * random.Uniform()),
          .then = Pick<FailureAction>(
              random, {FailureAction::kSkip, FailureAction::kPause, FailureAction::kStop})};
}

Script Draw(std::uint64_t seed) {
  Random random(seed, 1);
  Script s;
  const auto chance = [&](double p) { return random.Uniform() < p; };
  const auto some_time = [&] { return Seconds(50 + 130 * random.Uniform()); };
  s.rig = Pick<std::string>(random, {"sim-rig.yaml", "sim-rig.yaml", kSolidArms, kSolidArms,
                                     "rig-turntable.yaml", "rig-tilting-sample.yaml"});
  const bool solid = s.rig != "sim-rig.yaml";
  s.plan =
      Pick<std::string>(random, {"plan-information.yaml", "plan-random.yaml", "plan-grid.yaml"});
  s.material = Pick<std::string>(random, {"satin-paint", "retro-cloth", "glossy-plastic", "ptfe"});
  s.failures.pose = DrawPolicy(random, 1);
  if (chance(0.8)) s.failures.pose.then = FailureAction::kSkip;
  s.failures.instrument = DrawPolicy(random, 8);
  // Homing in the middle of a session is not watched: only for arms that cannot touch.
  s.failures.axis = DrawPolicy(random, solid ? 0 : 5);
  if (solid) s.failures.axis.then = FailureAction::kStop;
  s.failures.max_in_a_row = 3 + static_cast<int>(10 * random.Uniform());
  s.fault_rate = chance(0.1) ? 0 : std::exp(std::log(1e-3) + 3.5 * random.Uniform());
  if (chance(0.1)) s.stop_after_pose = some_time();
  if (chance(0.15)) s.stop_now = some_time();
  if (chance(0.15)) s.pause = some_time();
  if (chance(0.3)) {
    s.door = Pick<TripAction>(random, {TripAction::kSuspend, TripAction::kSuspend,
                                       TripAction::kStop, TripAction::kEmergencyStop});
    s.door_opens = chance(0.1) ? Seconds(0) : some_time();
    s.door_closes = s.door_opens + Seconds(60 * random.Uniform());
  }
  if (chance(0.1)) s.lamp_flicker = 0.1 * random.Uniform();
  if (chance(0.05)) s.lamp_fails_at = some_time();
  if (chance(0.05)) s.disk = static_cast<rlim_t>(100e3 + 200e3 * random.Uniform());
  return s;
}

// One process' share of a session: devices, faults, and who watches them.
class Shift {
 public:
  Shift(const Script& script, std::uint64_t seed, Seconds begin, const std::filesystem::path& dir,
        const TempDir& temp, CampaignResult* result)
      : script_(script),
        random_(seed, 2),
        dir_(dir),
        temp_(temp),
        result_(*result),
        sample_(OpenBrdf(ConfigPath("materials/" + script.material + ".yaml"))) {
    const std::string path = ConfigPath(script.rig);
    const ConfigNode root = ConfigNode::Load(path);
    rig_ = ReadRig(root, "");
    rig_.failures = script.failures;
    SimConfig truth = ReadSim(root);
    truth.lamp_flicker = script.lamp_flicker;
    truth.lamp_fails_at = script.lamp_fails_at.count();
    // Else a lamp that changes between the monitor's reading and the frame is nobody's to see.
    if (truth.lamp_flicker > 0 || truth.lamp_fails_at > 0) rig_.max_light_change = 0.03;
    auto ticking = std::make_unique<TickingClock>(begin);
    ticking->on_tick = [this] { Tick(); };
    clock_ = std::make_unique<WatchedClock>(std::move(ticking));
    SimDevices sim = MakeSimDevices(
        truth, {.axes = rig_.axes, .home_limit = rig_.motion.home_limit, .camera = rig_.camera},
        *sample_, *clock_, seed);
    draw_ = sim.draw;
    motors_ = sim.motors;
    lamp_ = sim.lamp;
    devices_ = {.axes = std::move(sim.axes),
                .camera = std::move(sim.camera),
                .light = std::move(sim.light),
                .monitor = std::move(sim.monitor)};
    if (script.rig == kSolidArms) watch_ = std::make_unique<CollisionWatch>(rig_);
    faulty_ = std::make_unique<FaultyRig>(
        devices_, [this](const auto& device, const auto& call) { return Fault(device, call); });
  }

  ~Shift() { devices_ = {}; }  // before their clock

  const RigConfig& rig() const { return rig_; }
  SessionInfo Info() const {
    SessionInfo info = SomeInfo();
    info.axes.assign(rig_.axis_names().begin(), rig_.axis_names().end());
    return info;
  }

  std::unique_ptr<Planner> ThePlanner() const {
    Plan plan = LoadPlan(ConfigPath(script_.plan));
    plan.max_poses = kPoses;
    if (IsInPlane(rig_.geometry.kind)) plan.StayInPlane();
    return MakePlanner(plan, {.reachable = [this](const DirectionPair& pair) {
                         return sample_->Eval(pair) && IsReachable(pair);
                       }});
  }

  SessionSummary Run(Planner& planner, EventLog& log, const SessionSoFar* so_far) {
    SessionParts parts{
        .rig = rig_, .devices = devices_, .clock = *clock_, .planner = planner, .log = &log};
    std::optional<Interlocks> interlocks;
    if (script_.door) {
      interlocks.emplace(Door(), devices_, *clock_, temp_.path());
      interlocks->WatchWith(*clock_);
      parts.interlocks = &*interlocks;
    }
    parts.so_far = so_far;
    parts.draw = draw_;
    parts.reopen = [&](FailureClass failure) -> Result<void> {
      // Not every cable is put in again.
      if (random_.Uniform() < 0.3) return Error{ErrorCode::kDisconnected, "no such port"};
      faulty_->Reopen(failure);
      return {};
    };
    parts.on_state = [&](SessionState state) { state_ = state; };
    const SessionStop stop{.after_pose = after_pose_.get_token(),
                           .now = now_.get_token(),
                           .pause = [&] { return Due(pause_, script_.pause); },
                           .wait = [&] { WaitForPerson(); }};
    SessionSummary summary = RunSession(parts, {}, stop);
    CheckEnd(summary);
    return summary;
  }

 private:
  // Ways are looked for once: all sessions on a rig choose from the same poses.
  bool IsReachable(const DirectionPair& pair) const {
    if (rig_.keep_out.light_arm.empty() && rig_.keep_out.camera_arm.empty()) {
      return Kinematics(rig_).Reachable(pair);
    }
    using Key = std::array<double, 6>;
    struct Ways {
      explicit Ways(const RigConfig& rig) : paths(rig) {}
      const PathPlanner paths;
      std::map<Key, bool> known;
      std::optional<AxisPositions> somewhere;
    };
    static std::map<std::string, Ways> rigs;
    Ways& ways = rigs.try_emplace(script_.rig, rig_).first->second;
    const Key key = {pair.wi.x(), pair.wi.y(), pair.wi.z(), pair.wo.x(), pair.wo.y(), pair.wo.z()};
    const auto found = ways.known.find(key);
    if (found != ways.known.end()) return found->second;
    const auto there = ways.paths.kinematics().Inverse(pair, {});
    if (!ways.somewhere && there && ways.paths.Plan(*there, *there)) ways.somewhere = there;
    return ways.known[key] = ways.somewhere && ways.paths.PlanTo(*ways.somewhere, pair).ok();
  }

  static bool Due(bool& done, const std::optional<Seconds>& at, Seconds now) {
    if (done || !at || now < *at) return false;
    return done = true;
  }
  bool Due(bool& done, const std::optional<Seconds>& at) { return Due(done, at, clock_->Now()); }

  InterlocksConfig Door() {
    InterlockSignal door;
    door.name = "door";
    door.kind = InterlockSignal::Kind::kFile;
    door.file = temp_.File("door", script_.door_opens > Seconds(0) ? "1\n" : "0\n");
    open_ = script_.door_opens <= Seconds(0);
    door.min = 1;
    door.hold = Seconds(3);
    door.action = *script_.door;
    return {.signals = {door}, .poll = Seconds(1), .longest_wait = Seconds(45)};
  }

  void WaitForPerson() {
    for (const auto& motor : motors_) {
      if (motor && motor->Moving()) Violation("an arm moves while a person is waited for");
    }
    clock_->SleepFor(Seconds(30), now_.get_token());
    if (random_.Uniform() < 0.2) after_pose_.request_stop();
  }

  // The truth, every 20 ms.
  void Tick() {
    const Seconds now = clock_->Now();
    if (now > kLongest) throw std::runtime_error("it never ends");
    if (Due(stopped_, script_.stop_after_pose, now)) after_pose_.request_stop();
    if (Due(aborted_, script_.stop_now, now)) now_.request_stop();
    if (script_.door) FollowDoor(now);
    const bool session_moves = state_ != SessionState::kUnhomed;  // homing is not watched
    if (!watch_ || !session_moves) return;
    ArmAngles angles{};
    bool moving = false;
    for (int i = 0; i < kAxes; ++i) {
      angles[i] = motors_[i]->Position();
      moving = moving || motors_[i]->Moving();
    }
    if (!moving) return;
    ++result_.looks;
    if (const auto contact = watch_->FindAt(angles, kTouching)) Violation(*contact + " touch");
  }

  void FollowDoor(Seconds now) {
    // And once more when the session has just gone on.
    const Seconds since = now - script_.door_closes;
    const bool open = now >= script_.door_opens &&
                      (since < Seconds(0) || (since > Seconds(4) && since < Seconds(7)));
    if (open == open_) return;
    open_ = open;
    temp_.File("door", open ? "0\n" : "1\n");
  }

  std::optional<Error> Fault(const std::string& device, const std::string& call) {
    if (++result_.calls > kMostCalls) throw std::runtime_error("it never ends");
    const bool start = call == "StartMove" || call == "Home";
    if (start) {
      ++result_.starts;
      if (now_.stop_requested()) Violation(device + " starts after an abort");
      if (pressed_) Violation(device + " starts after an emergency stop");
    }
    if (random_.Uniform() >= script_.fault_rate) return std::nullopt;
    ++result_.faults;
    const double kind = random_.Uniform();
    if (kind < 0.35) return Error{ErrorCode::kTimeout, "planted"};
    if (kind < 0.65) return Error{ErrorCode::kDisconnected, "planted"};
    if (kind < 0.9 || device.find('_') == std::string::npos) {
      return Error{ErrorCode::kProtocol, "planted"};
    }
    if (kind < 0.97) return Error{ErrorCode::kRefused, "planted"};
    pressed_ = call != "Stop";
    return Error{ErrorCode::kEmergencyStop, "planted"};
  }

  void CheckEnd(const SessionSummary& summary) {
    for (const auto& motor : motors_) {
      if (motor && motor->Moving()) Violation("an arm moves after the end");
    }
    if (lamp_->level() != 0 && !summary.clean_up_failed) Violation("the light is on after the end");
    for (const SessionPose& pose : summary.poses) {
      const BrdfSample& s = pose.samples.front();
      const Rgb truth = *sample_->Eval(s.directions);
      for (int c = 0; c < kChannels; ++c) {
        if (!std::isfinite(s.sigma[c])) continue;
        const double z = (s.f_r[c] - truth[c]) / s.sigma[c];
        if (std::abs(z) > kWrong) {
          Violation(fmt::format("a sample is wrong by {:.1f} sigmas: {} instead of {}", z, s.f_r[c],
                                truth[c]));
        }
      }
    }
  }

  void Violation(const std::string& what) {
    if (result_.violations.size() < 10) result_.violations.push_back(what);
  }

  const Script& script_;
  Random random_;
  const std::filesystem::path dir_;
  const TempDir& temp_;
  CampaignResult& result_;
  const std::unique_ptr<Brdf> sample_;
  RigConfig rig_;
  std::unique_ptr<WatchedClock> clock_;
  SimMotors motors_;
  std::shared_ptr<SimLamp> lamp_;
  std::function<void(std::uint64_t)> draw_;
  Devices devices_;
  std::unique_ptr<CollisionWatch> watch_;
  std::unique_ptr<FaultyRig> faulty_;
  std::stop_source after_pose_, now_;
  SessionState state_ = SessionState::kUnhomed;
  bool stopped_ = false, aborted_ = false, pause_ = false, open_ = false, pressed_ = false;
};

// The log has what the session says it has, and the planner decides as it did.
void CheckLog(const std::filesystem::path& dir, const Shift& shift, const SessionSummary& summary,
              CampaignResult* result) {
  for (const std::string& damage : FindDamage(dir)) result->violations.push_back(damage);
  const SessionRecord record = ReadSession(dir);
  result->events.clear();  // a session that goes on has those before in its log, too
  const bool trace = std::getenv("GONIO_CAMPAIGN_TRACE") != nullptr;
  for (const SessionEvent& event : record.events) {
    ++result->events[event.kind];
    if (trace) fmt::print("{:8.2f} {} {:.300}\n", event.time.count(), event.kind, event.body);
  }
  const auto unreduced = static_cast<std::size_t>(record.unreduced.has_value());
  if (record.poses.size() + unreduced < summary.poses.size()) {
    result->violations.push_back("a pose is not in the log");
  }
  const auto planner = shift.ThePlanner();
  const Retraced retraced = Retrace(record, HistoryOf(record), shift.rig(), *planner);
  if (retraced.first) result->violations.push_back(retraced.first->what);
}

SessionSummary Begin(const Script& script, std::uint64_t seed, const std::filesystem::path& dir,
                     const TempDir& temp, CampaignResult* result) {
  Shift shift(script, seed, Seconds(0), dir, temp, result);
  const auto planner = shift.ThePlanner();
  SessionSummary summary;
  {
    EventLog log = EventLog::Create(dir, shift.Info());
    std::optional<FileSizeLimit> full;
    if (script.disk) full.emplace(*script.disk);
    summary = shift.Run(*planner, log, nullptr);
  }
  CheckLog(dir, shift, summary, result);
  return summary;
}

// With all repaired, in another process.
SessionSummary Resume(Script script, std::uint64_t seed, const std::filesystem::path& dir,
                      const TempDir& temp, CampaignResult* result) {
  const SessionRecord record = ReadSession(dir);
  const SessionHistory history = HistoryOf(record);
  script.fault_rate = 0;
  script.stop_after_pose = script.stop_now = script.pause = std::nullopt;
  script.door.reset();
  script.disk.reset();
  script.lamp_fails_at = Seconds(0);
  script.lamp_flicker = 0;
  script.failures = FailuresConfig();
  Shift shift(script, seed, history.end, dir, temp, result);
  const auto planner = shift.ThePlanner();
  const Retraced retraced = Retrace(record, history, shift.rig(), *planner);
  SessionSummary summary;
  {
    EventLog log = EventLog::Open(dir);
    summary = shift.Run(*planner, log, &retraced.so_far);
  }
  CheckLog(dir, shift, summary, result);
  return summary;
}

}  // namespace

CampaignResult RunCampaignSession(std::uint64_t seed) {
  CampaignResult result;
  const TempDir temp;
  const std::filesystem::path dir = temp / "s";
  const Script script = Draw(seed);
  try {
    SessionSummary summary = Begin(script, seed, dir, temp, &result);
    result.outcome = summary.outcome;
    if (summary.outcome != SessionOutcome::kComplete && !ReadSession(dir).unreduced) {
      result.resumed = true;
      summary = Resume(script, seed, dir, temp, &result);
      if (summary.outcome != SessionOutcome::kComplete) {
        result.violations.push_back("resumed, but: " + summary.reason);
      }
    }
    result.poses = static_cast<int>(summary.poses.size());
  } catch (const std::exception& e) {
    result.violations.push_back(e.what());
  }
  return result;
}

}  // namespace gonio
