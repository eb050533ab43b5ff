// SPDX-License-Identifier: Apache-2.0
#include "acquisition/interlocks.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <system_error>
#include <utility>

namespace gonio {
namespace {

using Kind = InterlockSignal::Kind;

constexpr double kMegabyte = 1e6;

std::optional<double> NumberIn(const std::filesystem::path& path) {
  std::ifstream file(path);
  double number = 0;
  if (!(file >> number) || !std::isfinite(number)) return std::nullopt;
  return number;
}

// Empty: it is met. `inside`: by how much it has to be inside its band.
std::string Complaint(const InterlockSignal& signal, const std::optional<double>& value,
                      double inside) {
  if (!value) return fmt::format("{}: cannot be read", signal.name);
  if (signal.min && !(*value >= *signal.min + inside)) {
    return fmt::format("{}: is {:.6g}, must be >= {:.6g}", signal.name, *value,
                       *signal.min + inside);
  }
  if (signal.max && !(*value <= *signal.max - inside)) {
    return fmt::format("{}: is {:.6g}, must be <= {:.6g}", signal.name, *value,
                       *signal.max - inside);
  }
  return {};
}

Kind ReadKind(const ConfigNode& node) {
  const std::string kind = node.Choice("signal", {"lamp", "camera-temperature", "disk", "file"});
  if (kind == "lamp") return Kind::kLamp;
  if (kind == "camera-temperature") return Kind::kCameraTemperature;
  return kind == "disk" ? Kind::kDiskFree : Kind::kFile;
}

TripAction ReadAction(const ConfigNode& node) {
  const std::string action = node.Choice("when_tripped", {"suspend", "stop", "emergency-stop"});
  if (action == "suspend") return TripAction::kSuspend;
  return action == "stop" ? TripAction::kStop : TripAction::kEmergencyStop;
}

// What can be asked of no device.
bool IsOfSurroundings(Kind kind) { return kind == Kind::kFile || kind == Kind::kDiskFree; }

InterlockSignal ReadSignal(const ConfigNode& node, const std::filesystem::path& beside) {
  InterlockSignal signal;
  signal.name = node.Text("name");
  signal.kind = ReadKind(node);
  if (signal.kind == Kind::kFile) signal.file = beside / node.Text("file");
  if (node.Has("min")) signal.min = node.Number("min");
  if (node.Has("max")) signal.max = node.Number("max");
  if (!signal.min && !signal.max) node.Fail("min", "this or max is needed");
  signal.hysteresis = node.NumberOr("hysteresis", 0, Range::NonNegative());
  signal.hold = Seconds(node.NumberOr("hold_s", signal.hold.count(), Range::NonNegative()));
  if (node.Has("when_tripped")) signal.action = ReadAction(node);
  return signal;
}

}  // namespace

InterlocksConfig ReadInterlocks(const ConfigNode& root, const std::filesystem::path& beside) {
  InterlocksConfig config;
  if (!root.Has("interlocks")) return config;
  const ConfigNode node = root.Map("interlocks");
  config.poll = Seconds(node.NumberOr("poll_s", config.poll.count(), Range::Positive()));
  config.longest_wait = Seconds(
      60 * node.NumberOr("longest_wait_min", config.longest_wait.count() / 60, Range::Positive()));
  for (const ConfigNode& signal : node.MapList("signals")) {
    config.signals.push_back(ReadSignal(signal, beside));
  }
  return config;
}

Error ErrorOf(const Trip& trip) {
  return {
      trip.action == TripAction::kEmergencyStop ? ErrorCode::kEmergencyStop : ErrorCode::kProtocol,
      "interlock " + trip.message};
}

// The devices themselves, and what was seen through them.
class Interlocks::Watch {
 public:
  Watch(const InterlocksConfig& config, std::filesystem::path disk)
      : config_(config), disk_(std::move(disk)) {}

  void Take(Devices& devices) {
    camera_ = std::move(devices.camera);
    monitor_ = std::move(devices.monitor);
  }
  void Give(Devices& devices) {
    devices.camera = std::move(camera_);
    devices.monitor = std::move(monitor_);
  }

  Camera& camera() { return *camera_; }
  Monitor& monitor() { return *monitor_; }

  // What needs no device: at the begin and end of every exposure.
  void LookAround() {
    for (const InterlockSignal& signal : config_.signals) {
      if (IsOfSurroundings(signal.kind)) Judge(signal, Read(signal));
    }
  }
  // While axes move.
  void LookAhead() {
    LookAround();
    if (trip_ && on_trip_) on_trip_();
  }
  void SetOnTrip(std::function<void()> on_trip) { on_trip_ = std::move(on_trip); }

  void SeeLamp(double reading) { JudgeAll(Kind::kLamp, reading); }
  void SeeFrame(const Frame& frame) {
    temperature_ = frame.temperature_c;
    JudgeAll(Kind::kCameraTemperature, temperature_);
  }

  void LookAtAll() {
    for (const InterlockSignal& signal : config_.signals) Judge(signal, Read(signal));
  }

  // A camera tells its temperature with a frame only.
  void RefreshTemperature(const std::stop_token& stop) {
    const bool wanted = std::any_of(
        config_.signals.begin(), config_.signals.end(),
        [](const InterlockSignal& signal) { return signal.kind == Kind::kCameraTemperature; });
    if (!wanted) return;
    if (!camera_) return;
    const auto frame = camera_->Capture(camera_->info().min_exposure, stop);
    if (frame) temperature_ = frame->temperature_c;
  }

  std::optional<Trip> TakeTrip() { return std::exchange(trip_, std::nullopt); }

  // Of this moment, the lamp included; a camera that has not exposed yet has no temperature.
  std::optional<double> Read(const InterlockSignal& signal) {
    switch (signal.kind) {
      case Kind::kLamp: {
        if (!monitor_) return std::nullopt;
        const auto reading = monitor_->Read();
        return reading ? std::optional(*reading) : std::nullopt;
      }
      case Kind::kCameraTemperature:
        return temperature_;
      case Kind::kDiskFree: {
        std::error_code error;
        const auto space = std::filesystem::space(disk_, error);
        if (error) return std::nullopt;
        return static_cast<double>(space.available) / kMegabyte;
      }
      case Kind::kFile:
        return NumberIn(signal.file);
    }
    return std::nullopt;
  }

 private:
  void JudgeAll(Kind kind, const std::optional<double>& value) {
    for (const InterlockSignal& signal : config_.signals) {
      if (signal.kind == kind) Judge(signal, value);
    }
  }
  // The first trip stays, unless a later one is worse.
  void Judge(const InterlockSignal& signal, const std::optional<double>& value) {
    if (signal.kind == Kind::kCameraTemperature && !value) return;
    std::string complaint = Complaint(signal, value, 0);
    if (complaint.empty() || (trip_ && trip_->action >= signal.action)) return;
    trip_ = Trip{signal.name, std::move(complaint), signal.action};
  }

  const InterlocksConfig config_;
  std::unique_ptr<Camera> camera_;
  std::unique_ptr<Monitor> monitor_;
  const std::filesystem::path disk_;
  std::function<void()> on_trip_;
  std::optional<double> temperature_;
  std::optional<Trip> trip_;
};

class Interlocks::WatchedCamera final : public Camera {
 public:
  explicit WatchedCamera(std::shared_ptr<Watch> watch) : watch_(std::move(watch)) {}
  const std::string& name() const override { return watch_->camera().name(); }
  const std::string& identity() const override { return watch_->camera().identity(); }
  const CameraInfo& info() const override { return watch_->camera().info(); }
  Result<Frame> Capture(Seconds exposure, std::stop_token stop) override {
    watch_->LookAround();
    auto frame = watch_->camera().Capture(exposure, std::move(stop));
    watch_->LookAround();
    if (frame) watch_->SeeFrame(*frame);
    return frame;
  }

 private:
  const std::shared_ptr<Watch> watch_;
};

class Interlocks::WatchedMonitor final : public Monitor {
 public:
  explicit WatchedMonitor(std::shared_ptr<Watch> watch) : watch_(std::move(watch)) {}
  const std::string& name() const override { return watch_->monitor().name(); }
  const std::string& identity() const override { return watch_->monitor().identity(); }
  Result<double> Read() override {
    auto reading = watch_->monitor().Read();
    if (reading) watch_->SeeLamp(*reading);
    return reading;
  }
  Result<void> Expect(LightColour colour) override { return watch_->monitor().Expect(colour); }

 private:
  const std::shared_ptr<Watch> watch_;
};

Interlocks::Interlocks(InterlocksConfig config, Devices& devices, Clock& clock,
                       std::filesystem::path disk)
    : config_(std::move(config)),
      clock_(clock),
      watch_(std::make_shared<Watch>(config_, std::move(disk))) {
  Wrap(devices);
}

Interlocks::~Interlocks() {
  if (watched_ != nullptr) watched_->Watch(kWatchInterval, {});
}

void Interlocks::Wrap(Devices& devices) {
  watch_->Take(devices);
  devices.camera = std::make_unique<WatchedCamera>(watch_);
  devices.monitor = std::make_unique<WatchedMonitor>(watch_);
}

void Interlocks::Release(Devices& devices) { watch_->Give(devices); }

void Interlocks::WatchWith(WatchedClock& clock) {
  watched_ = &clock;
  clock.Watch(kWatchInterval, [watch = watch_] { watch->LookAhead(); });
}

void Interlocks::SetOnTrip(std::function<void()> on_trip) { watch_->SetOnTrip(std::move(on_trip)); }

std::optional<Trip> Interlocks::Check() {
  watch_->LookAtAll();
  return watch_->TakeTrip();
}

std::optional<Trip> Interlocks::CheckSurroundings() {
  watch_->LookAround();
  return watch_->TakeTrip();
}

Result<void> Interlocks::WaitUntilClear(const std::stop_token& stop) { return Wait(stop, false); }

Result<void> Interlocks::WaitForSurroundings(const std::stop_token& stop) {
  return Wait(stop, true);
}

Result<void> Interlocks::Wait(const std::stop_token& stop, bool surroundings_only) {
  const Seconds begin = clock_.Now();
  std::vector<std::optional<Seconds>> clear_since(config_.signals.size());
  for (;;) {
    std::string waiting_for;
    for (std::size_t i = 0; i < config_.signals.size(); ++i) {
      const InterlockSignal& signal = config_.signals[i];
      if (surroundings_only && !IsOfSurroundings(signal.kind)) continue;
      std::string not_clear = NotClear(signal, &clear_since[i]);
      if (!not_clear.empty()) waiting_for = std::move(not_clear);
    }
    if (waiting_for.empty()) break;
    if (clock_.Now() - begin >= config_.longest_wait) {
      return Error{ErrorCode::kTimeout,
                   fmt::format("suspended for {:.3g} min, interlocks.longest_wait_min: {}",
                               config_.longest_wait.count() / 60, waiting_for)};
    }
    clock_.SleepFor(config_.poll, stop);
    if (stop.stop_requested()) return Error{ErrorCode::kCancelled, "suspended: cancelled"};
    if (!surroundings_only) watch_->RefreshTemperature(stop);
  }
  (void)watch_->TakeTrip();  // what was seen meanwhile
  return {};
}

// Why not; empty: it is, by its hysteresis and for its hold. `since`: when it began to be.
std::string Interlocks::NotClear(const InterlockSignal& signal, std::optional<Seconds>* since) {
  const std::optional<double> value = watch_->Read(signal);
  const bool unknown = signal.kind == Kind::kCameraTemperature && !value;
  std::string complaint = unknown ? "" : Complaint(signal, value, signal.hysteresis);
  if (!complaint.empty()) {
    since->reset();
    return complaint;
  }
  if (!*since) *since = clock_.Now();
  if (clock_.Now() - **since >= signal.hold) return {};
  return fmt::format("{}: is clear for less than {:.3g} s", signal.name, signal.hold.count());
}

}  // namespace gonio
