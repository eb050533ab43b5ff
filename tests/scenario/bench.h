// SPDX-License-Identifier: Apache-2.0
// A simulated rig on a test bench: real session code, simulated devices that are watched, a planner
// that follows a script.

#pragma once

#include <gtest/gtest.h>
#include <sys/resource.h>

#include <algorithm>
#include <csignal>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "acquisition/session.h"
#include "brdf/analytic.h"
#include "core/config.h"
#include "core/file.h"
#include "core/units.h"
#include "sim/sim_axis.h"
#include "sim/sim_rig.h"

namespace gonio {

// Proposes what it was given, in that order, and remembers what it was told.
class ScriptedPlanner : public Planner {
 public:
  explicit ScriptedPlanner(std::vector<HalfDiff> script) : script_(std::move(script)) {}

  std::optional<Proposal> Next() override {
    if (next_ == script_.size()) return std::nullopt;
    const auto index = static_cast<int>(next_);
    return Proposal{ToDirections(script_[next_]), index, 0.5 * index, "script"};
  }
  void Observe(const Proposal&, const BrdfSample& sample) override {
    ++next_;
    observed.push_back(sample);
    if (on_observe) on_observe(static_cast<int>(observed.size()));
  }
  void Reject(const Proposal& proposal) override {
    ++next_;
    rejected.push_back(proposal.candidate);
  }
  std::string reason() const override { return "end of script"; }
  int MaxPoses() const override { return static_cast<int>(script_.size()); }
  std::optional<double> PredictedError() const override { return 1.0 / (1 + observed.size()); }

  std::vector<BrdfSample> observed;
  std::vector<int> rejected;            // candidates
  std::function<void(int)> on_observe;  // with the number of samples so far

 private:
  std::vector<HalfDiff> script_;
  std::size_t next_ = 0;
};

// Passes everything on and notes whether an axis moved while the shutter was open.
class WatchedCamera final : public Camera {
 public:
  WatchedCamera(std::unique_ptr<Camera> camera, SimMotors motors, const Clock& clock)
      : camera_(std::move(camera)), motors_(std::move(motors)), clock_(clock) {}

  const std::string& name() const override { return camera_->name(); }
  const std::string& identity() const override { return camera_->identity(); }
  const CameraInfo& info() const override { return camera_->info(); }
  Result<Frame> Capture(Seconds exposure, std::stop_token stop) override {
    ++captures;
    if (on_capture) on_capture(captures);
    const Seconds begin = clock_.Now();
    Result<Frame> frame = camera_->Capture(exposure, stop);
    for (const auto& motor : motors_) {
      if (motor->MovingBetween(begin, clock_.Now())) ++captures_while_moving;
    }
    return frame;
  }

  int captures = 0;
  int captures_while_moving = 0;
  std::function<void(int)> on_capture;  // before the exposure, with its number

 private:
  std::unique_ptr<Camera> camera_;
  SimMotors motors_;
  const Clock& clock_;
};

// Another clock's time.
class SameClock final : public Clock {
 public:
  explicit SameClock(Clock& clock) : clock_(clock) {}
  Seconds Now() const override { return clock_.Now(); }
  void SleepFor(Seconds duration, std::stop_token stop) override {
    clock_.SleepFor(duration, std::move(stop));
  }

 private:
  Clock& clock_;
};

// configs/sim-rig.yaml, opened.
class Bench {
 public:
  explicit Bench(std::uint64_t seed = 1) : Bench(seed, Seconds(0), false) {}

 protected:
  Bench(std::uint64_t seed, Seconds begin, bool steady) : clock(begin) {
    const std::string path = std::string(GONIO_SOURCE_DIR) + "/configs/sim-rig.yaml";
    const std::string text = ReadTextFile(path);
    const ConfigNode root = ConfigNode::Parse(text, path);
    rig = ReadRig(root, text);
    const SimSetup setup{
        .axes = rig.axes, .home_limit = rig.motion.home_limit, .camera = rig.camera};
    SimConfig truth = ReadSim(root);
    if (steady) truth.repeatability = truth.encoder_resolution = truth.light_drift_per_hour = 0;
    SimDevices sim = MakeSimDevices(truth, setup, sample, device_clock, seed);
    draw = sim.draw;
    motors = sim.motors;
    lamp = sim.lamp;
    auto watched = std::make_unique<WatchedCamera>(std::move(sim.camera), sim.motors, clock);
    camera = watched.get();
    devices = {.axes = std::move(sim.axes),
               .camera = std::move(watched),
               .light = std::move(sim.light),
               .monitor = std::move(sim.monitor)};
  }

 public:
  SessionSummary Run(Planner& planner, EventLog* log = nullptr, const SessionOptions& options = {},
                     const SessionStop& stop = {}, const ProgressFunction& progress = {}) {
    return RunSession({rig, devices, clock, planner, log}, options, stop, progress);
  }

  SimAxis& axis(int index) { return dynamic_cast<SimAxis&>(*devices.axes[index]); }
  bool AnythingMoves() const {
    return std::any_of(motors.begin(), motors.end(), [](const auto& m) { return m->Moving(); });
  }

  const AnalyticBrdf sample{"grey", {Lambert{Rgb(0.2, 0.4, 0.6)}}};
  ManualClock clock;
  WatchedClock device_clock{std::make_unique<SameClock>(clock)};  // what devices wait on
  RigConfig rig;
  SimMotors motors;
  std::shared_ptr<SimLamp> lamp;
  WatchedCamera* camera = nullptr;
  Devices devices;
  std::function<void(std::uint64_t)> draw;
};

// The same with a steady light and arms that end where they are sent: homing it again, later,
// changes nothing.
class SteadyBench : public Bench {
 public:
  explicit SteadyBench(Seconds begin = Seconds(0)) : Bench(1, begin, true) {}
};

inline HalfDiff Degrees(double theta_h, double theta_d, double phi_d = 90) {
  return {RadFromDeg(theta_h), RadFromDeg(theta_d), RadFromDeg(phi_d)};
}

// Within reach of the simulated rig, well apart.
inline std::vector<HalfDiff> FourPoses() {
  return {Degrees(5, 20), Degrees(30, 40), Degrees(60, 15), Degrees(10, 60)};
}

// theta_d = 0: the arms would touch.
inline HalfDiff OutOfReach() { return Degrees(20, 0); }

inline SessionInfo SomeInfo() {
  SessionInfo info;
  info.gonio_version = "0.0";
  info.seed = 18446744073709551615u;
  info.max_poses = 7;
  info.rig_name = "bench";
  info.rig_text = "rig: 1\n";
  info.plan_text = "plan: 1\n";
  info.prior_name = "generic";
  info.devices = {{"camera", "sim-camera"}, {"light", "lamp \"A\""}};
  return info;
}

// While one lives, no file of this process can grow beyond `bytes`: a full disk that needs no root.
class FileSizeLimit {
 public:
  explicit FileSizeLimit(rlim_t bytes) {
    old_handler_ = std::signal(SIGXFSZ, SIG_IGN);
    getrlimit(RLIMIT_FSIZE, &old_);
    rlimit limit = old_;
    limit.rlim_cur = bytes;
    setrlimit(RLIMIT_FSIZE, &limit);
  }
  ~FileSizeLimit() {
    setrlimit(RLIMIT_FSIZE, &old_);
    std::signal(SIGXFSZ, old_handler_);
  }
  FileSizeLimit(const FileSizeLimit&) = delete;
  FileSizeLimit& operator=(const FileSizeLimit&) = delete;

 private:
  rlimit old_{};
  void (*old_handler_)(int) = nullptr;
};

}  // namespace gonio
