// SPDX-License-Identifier: Apache-2.0
// An open GenICam camera: its settings made, its stream armed. What GenicamCamera's thread owns.

#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "drivers/deadline.h"
#include "drivers/genicam_camera.h"

namespace gonio {

// An image as it came.
struct GenicamImage {
  std::vector<std::uint16_t> counts;
  // What it says that it was taken with, if it does.
  std::optional<Seconds> exposure;
  std::optional<double> gain_db;
};

// One thread: Aravis' objects are not for several. Errors: kDisconnected once the camera does not
// answer, after which only the destructor makes sense; others as GenicamFeatures.
class GenicamLink {
 public:
  // Finds the camera, makes every setting and reads it back, and arms the stream.
  static Result<std::unique_ptr<GenicamLink>> Open(const GenicamSettings& settings);
  ~GenicamLink();

  const CameraInfo& info() const;
  const std::string& identity() const;
  double gain_db() const;      // read back
  double black_level() const;  // read back; 0 if the camera has none
  // Whether every image says its exposure.
  bool tells_exposure() const;

  // Returns what the camera made of it.
  Result<Seconds> SetExposure(Seconds exposure);
  Result<double> Temperature();  // deg C; kRefused if it does not tell

  // Forgets images that came without being asked for, then takes one.
  void DropImages();
  Result<void> Trigger();
  // kTimeout: none came. kProtocol: one came that is not whole; what it was is counted in `bad`.
  // kCancelled: `abandoned` says so.
  Result<GenicamImage> WaitForImage(const Deadline& deadline,
                                    const std::function<bool()>& abandoned,
                                    std::map<std::string, int>& bad);

  // Ends what is being exposed.
  Result<void> Restart();
  // Whether it answers, and still has the settings that were made: after a short loss of power it
  // answers as if nothing had happened.
  Result<void> CheckAlive();
  // The camera is gone: closing it does not wait for its answers.
  void GiveUp();
  // It has told, or Aravis has noticed, that it no longer obeys. Any thread.
  bool lost() const;

 private:
  class Impl;
  explicit GenicamLink(std::unique_ptr<Impl> impl);
  const std::unique_ptr<Impl> impl_;
};

}  // namespace gonio
