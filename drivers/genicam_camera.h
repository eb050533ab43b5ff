// SPDX-License-Identifier: Apache-2.0
// A GigE Vision or USB3 Vision camera, through Aravis.

#pragma once

#include <map>
#include <memory>
#include <optional>
#include <string>

#include "drivers/camera.h"

namespace gonio {

struct GenicamSettings {
  std::string name;  // in every error message

  // Which camera: exactly one of these. An address reaches the GigE camera there and sends nothing
  // elsewhere; the others search USB, and the network by a broadcast on every interface.
  std::string address;    // "192.168.1.20"
  std::string serial;     // as the camera tells it
  std::string device_id;  // Aravis': "Basler-21876523"

  std::string pixel_format = "Mono12";  // of PFNC; drivers/pixel_unpacking.h knows which
  int width = 0;                        // pixels of the region that is read out
  int height = 0;
  int offset_x = 0;  // of its first pixel on the sensor
  int offset_y = 0;
  double gain_db = 0;
  // What one step of an old camera's GainRaw is [dB], from its manual. 0: not known, then only
  // cameras with Gain are taken.
  double gain_raw_step_db = 0;
  std::optional<double> black_level;  // in the camera's unit, mostly counts; none: as it is
  std::string trigger_line;           // "Line1": its rising edge; empty: a software trigger
  int packet_size = 0;                // bytes of GigE packets; 0: as Aravis finds it

  Seconds readout{0.05};    // an upper bound, unless the camera tells
  Seconds margin{0.5};      // >= 0.3: a frame may be late by so much before it is given up
  int retries = 8;          // frames taken again after one that was late or not whole
  int discarded_first = 1;  // frames thrown away after opening and after a restart
  int discarded_on_change =
      1;                     // and after the exposure time was changed, if frames do not say theirs
  bool chunk_data = true;    // let frames say how they were taken, if the camera has that
  Seconds reopen_limit{10};  // a camera that was lost is looked for so long, per frame
};

// What has happened so far.
struct GenicamCounters {
  int frames = 0;     // handed out
  int discarded = 0;  // thrown away on purpose
  int late = 0;       // that said that they were taken with earlier settings; taken again
  int retries = 0;
  int reopened = 0;
  // Frames that were not whole, by what Aravis or we found: "missing packets", "time-out" (of some
  // of its packets), "size", ..., and "none": nothing came at all.
  std::map<std::string, int> bad;
};

// What the camera must be: settings are written when it is opened and after it was lost, read back,
// and a difference is refused, for the software is master. Automatics are switched off.
//
// The camera belongs to a thread of its own, armed for one trigger per frame. Capture() waits for
// that thread, but never longer than
//
//   (1 + retries) (1 + discarded) (exposure + readout + margin) + reopen_limit + 12 s,
//
// whatever the camera or its driver do; what hangs is left behind, and the next Capture() waits for
// it within its own limit.
//
// Many cameras apply a change of the exposure time a frame or two late. Where frames say how they
// were taken (chunk data: ChunkExposureTime, ChunkGain), Frame has what the frame says, and one
// that says something else than what is set is taken again: no frame is ever taken for one of
// another exposure. Elsewhere Frame has what the camera read back, and `discarded_on_change` frames
// after a change are thrown away: right for cameras that are late by no more than that.
//
// Errors of Capture(), after the repeats:
//
//   kTimeout       no frame came, but the camera answers
//   kProtocol      no frame was whole, or none was taken as it was set
//   kDisconnected  it does not answer, and was not found again within reopen_limit
//   kRefused       exposure out of range, or the camera that came back is not as it was
//
// With a trigger line, a frame is one whose edge came after the call; nobody's edge: kTimeout.
class GenicamCamera final : public Camera {
 public:
  // `clock` must outlive it, and be for any thread. kRefused: not there, in another program's
  // hands, or it does not take a setting, which the message names.
  static Result<std::unique_ptr<GenicamCamera>> Open(const GenicamSettings& settings, Clock& clock);
  ~GenicamCamera() override;

  const std::string& name() const override;
  const std::string& identity() const override;
  const CameraInfo& info() const override;
  Result<Frame> Capture(Seconds exposure, std::stop_token stop) override;

  GenicamCounters counters() const;
  // How long Capture() takes at most, of the machine's time.
  Seconds CaptureLimit(Seconds exposure) const;

 private:
  class Impl;
  explicit GenicamCamera(std::unique_ptr<Impl> impl);
  const std::unique_ptr<Impl> impl_;
};

}  // namespace gonio
