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
  signal.stop =
      node.Has("when_tripped") && node.Choice("when_tripped", {"suspend", "stop"}) == "stop";
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

// The devices themselves, and what was seen through them.
class Interlocks::Watch {
 public:
  Watch(const InterlocksConfig& config, Devices& devices, std::filesystem::path disk)
      : config_(config),
        camera_(std::move(devices.camera)),
        monitor_(std::move(devices.monitor)),
        disk_(std::move(disk)) {}

  Camera& camera() { return *camera_; }
  Monitor& monitor() { return *monitor_; }

  // What needs no device: at the begin and end of every exposure.
  void LookAround() {
    for (const InterlockSignal& signal : config_.signals) {
      if (signal.kind == Kind::kFile || signal.kind == Kind::kDiskFree) Judge(signal, Read(signal));
    }
  }
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
    const auto frame = camera_->Capture(camera_->info().min_exposure, stop);
    if (frame) temperature_ = frame->temperature_c;
  }

  std::optional<Trip> TakeTrip() { return std::exchange(trip_, std::nullopt); }

  // Of this moment, the lamp included; a camera that has not exposed yet has no temperature.
  std::optional<double> Read(const InterlockSignal& signal) {
    switch (signal.kind) {
      case Kind::kLamp: {
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
    if (complaint.empty() || (trip_ && (trip_->stop || !signal.stop))) return;
    trip_ = Trip{signal.name, std::move(complaint), signal.stop};
  }

  const InterlocksConfig config_;
  const std::unique_ptr<Camera> camera_;
  const std::unique_ptr<Monitor> monitor_;
  const std::filesystem::path disk_;
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

 private:
  const std::shared_ptr<Watch> watch_;
};

Interlocks::Interlocks(InterlocksConfig config, Devices& devices, Clock& clock,
                       std::filesystem::path disk)
    : config_(std::move(config)),
      clock_(clock),
      watch_(std::make_shared<Watch>(config_, devices, std::move(disk))) {
  devices.camera = std::make_unique<WatchedCamera>(watch_);
  devices.monitor = std::make_unique<WatchedMonitor>(watch_);
}

Interlocks::~Interlocks() = default;

std::optional<Trip> Interlocks::Check() {
  watch_->LookAtAll();
  return watch_->TakeTrip();
}

Result<void> Interlocks::WaitUntilClear(const std::stop_token& stop) {
  const Seconds begin = clock_.Now();
  std::vector<std::optional<Seconds>> clear_since(config_.signals.size());
  for (;;) {
    std::string waiting_for;
    for (std::size_t i = 0; i < config_.signals.size(); ++i) {
      const InterlockSignal& signal = config_.signals[i];
      const std::optional<double> value = watch_->Read(signal);
      const bool unknown = signal.kind == Kind::kCameraTemperature && !value;
      std::string complaint = unknown ? "" : Complaint(signal, value, signal.hysteresis);
      if (!complaint.empty()) {
        clear_since[i].reset();
        waiting_for = std::move(complaint);
      } else if (!clear_since[i]) {
        clear_since[i] = clock_.Now();
      }
      if (clear_since[i] && clock_.Now() - *clear_since[i] < signal.hold && waiting_for.empty()) {
        waiting_for =
            fmt::format("{}: is clear for less than {:.3g} s", signal.name, signal.hold.count());
      }
    }
    if (waiting_for.empty()) break;
    if (clock_.Now() - begin >= config_.longest_wait) {
      return Error{ErrorCode::kTimeout,
                   fmt::format("suspended for {:.3g} min, interlocks.longest_wait_min: {}",
                               config_.longest_wait.count() / 60, waiting_for)};
    }
    clock_.SleepFor(config_.poll, stop);
    if (stop.stop_requested()) return Error{ErrorCode::kCancelled, "suspended: cancelled"};
    watch_->RefreshTemperature(stop);
  }
  (void)watch_->TakeTrip();  // what was seen meanwhile
  return {};
}

}  // namespace gonio
