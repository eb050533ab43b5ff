// SPDX-License-Identifier: Apache-2.0
// Conditions without which nothing is measured: a closed door, a lamp in its band, room on the
// disk.
//
// A session is suspended while one is not met and goes on by itself; what was exposed meanwhile is
// discarded. They protect measurements. What protects people belongs into hardware.

#pragma once

#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

#include "acquisition/rig.h"
#include "core/clock.h"
#include "core/config.h"
#include "core/error.h"

namespace gonio {

enum class TripAction {
  kSuspend,        // nothing is measured until it is clear
  kStop,           // the session ends, arms at once
  kEmergencyStop,  // the same, and arms brake as hard as they can
};

// One entry of `interlocks.signals` in a rig file.
struct InterlockSignal {
  enum class Kind {
    kLamp,               // the monitor, relative to calibration
    kCameraTemperature,  // deg C, of the last frame
    kDiskFree,           // MB, where the session is written
    kFile,               // the number a file holds, which some other program writes
  };
  std::string name;
  Kind kind = Kind::kFile;
  std::filesystem::path file;  // of kFile
  std::optional<double> min;   // in the signal's unit; one of the two is there
  std::optional<double> max;
  double hysteresis = 0;  // >= 0: once tripped it has to be so far inside to be clear
  Seconds hold{10};       // >= 0: and for so long
  TripAction action = TripAction::kSuspend;
};

struct InterlocksConfig {
  std::vector<InterlockSignal> signals;
  Seconds poll{1};             // > 0: how often to look while suspended
  Seconds longest_wait{3600};  // > 0: a suspension that lasts longer ends the session
};

// The `interlocks` mapping of a rig file; relative files are beside the rig's. Without one: no
// signals. Throws ConfigError.
InterlocksConfig ReadInterlocks(const ConfigNode& root, const std::filesystem::path& beside);

// A condition that is not met.
struct Trip {
  std::string signal;
  std::string message;  // "door: is 0, must be >= 1"
  TripAction action = TripAction::kSuspend;
};
// What a session ends with because of it.
Error ErrorOf(const Trip& trip);

// Looks at the signals of a session. One thread.
class Interlocks {
 public:
  // Puts itself between the session and its camera and monitor, so that every exposure is watched
  // from before it to after it, and every reading of the lamp. `devices` and `clock` must outlive
  // it; destroying it leaves the devices as they are, and they must not be used any more.
  // `disk`: a folder on the disk that kDiskFree is about.
  Interlocks(InterlocksConfig config, Devices& devices, Clock& clock, std::filesystem::path disk);
  ~Interlocks();
  Interlocks(const Interlocks&) = delete;
  Interlocks& operator=(const Interlocks&) = delete;

  // The first condition that is not met: now, or at some time since this was asked last. Signals
  // that cannot be read are not met.
  std::optional<Trip> Check();
  // The same of the signals that need no device, which can be asked before any is ready.
  std::optional<Trip> CheckSurroundings();

  // From now on these are looked at while axes move, too: whenever their drivers wait on `clock`,
  // at least every kWatchInterval. `on_trip` is called, in the thread that waits, at each look that
  // finds one that is not met: to stop what is going on. Empty: nothing is stopped. `clock` must
  // outlive this.
  void WatchWith(WatchedClock& clock);
  void SetOnTrip(std::function<void()> on_trip);
  static constexpr Seconds kWatchInterval{0.05};

  // Blocks until all are clear by their hysteresis and have been for their hold. kTimeout after
  // longest_wait, with what is still not met; kCancelled; errors of the devices.
  Result<void> WaitUntilClear(const std::stop_token& stop);
  // The same for the signals that need no device.
  Result<void> WaitForSurroundings(const std::stop_token& stop);

  // Gives camera and monitor back, so that they can be closed and opened anew; takes them again.
  void Release(Devices& devices);
  void Wrap(Devices& devices);

 private:
  class Watch;
  class WatchedCamera;
  class WatchedMonitor;

  Result<void> Wait(const std::stop_token& stop, bool surroundings_only);
  std::string NotClear(const InterlockSignal& signal, std::optional<Seconds>* since);

  const InterlocksConfig config_;
  Clock& clock_;
  WatchedClock* watched_ = nullptr;
  std::shared_ptr<Watch> watch_;  // shared with the wrapped devices
};

}  // namespace gonio
