// SPDX-License-Identifier: Apache-2.0
#include "drivers/genicam_link.h"

#include <arpa/inet.h>
#include <arv.h>
#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <span>
#include <utility>

#include "drivers/genicam_features.h"
#include "drivers/genicam_list.h"
#include "drivers/genicam_setup.h"

namespace gonio {
namespace {

struct Unref {
  void operator()(void* object) const { g_object_unref(object); }
};
using CameraHandle = std::unique_ptr<ArvCamera, Unref>;
using StreamHandle = std::unique_ptr<ArvStream, Unref>;
using ChunkHandle = std::unique_ptr<ArvChunkParser, Unref>;

constexpr int kBuffers = 4;
// At least; the default of the system loses most frames, says a measurement. It may grant less:
// `gonio doctor` says so.
constexpr guint kSocketBytes = 4 << 20;
constexpr guint64 kSlice = 20'000;          // us between looks at who gave up waiting
constexpr double kMicrosecond = 1e-6;       // s
constexpr double kExposureTolerance = 0.1;  // share of the exposure, of the rounding of short ones

Error Refused(std::string message) { return {ErrorCode::kRefused, std::move(message)}; }

Result<std::string> IdOfSerial(const std::string& serial) {
  arv_update_device_list();
  std::string others;
  for (unsigned i = 0; i < arv_get_n_devices(); ++i) {
    const char* found = arv_get_device_serial_nbr(i);
    if (found && found == serial) return std::string(arv_get_device_id(i));
    others += fmt::format("{}{}", others.empty() ? "" : ", ", found ? found : "?");
  }
  return Refused(fmt::format("no camera with serial number {}; there {}", serial,
                             others.empty() ? "is none" : "are " + others));
}

Result<CameraHandle> Find(const GenicamSettings& settings) {
  const std::lock_guard lock(GenicamListMutex());
  std::string id = settings.device_id;
  if (!settings.address.empty()) {
    in_addr unused{};
    // Aravis would look for anything else all over the network.
    if (inet_pton(AF_INET, settings.address.c_str(), &unused) != 1) {
      return Refused(settings.address + " is no IPv4 address");
    }
    id = settings.address;
  } else if (!settings.serial.empty()) {
    const auto found = IdOfSerial(settings.serial);
    if (!found) return found.error();
    id = *found;
  }
  GError* error = nullptr;
  CameraHandle camera(arv_camera_new(id.c_str(), &error));
  if (error || !camera) {
    return Refused(GenicamError(error, "no camera at " + id).message);
  }
  ArvDevice* device = arv_camera_get_device(camera.get());
  if (ARV_IS_GV_DEVICE(device) && !arv_gv_device_is_controller(ARV_GV_DEVICE(device))) {
    return Refused("another program controls the camera at " + id);
  }
  return camera;
}

const char* NameOf(ArvBufferStatus status) {
  switch (status) {
    case ARV_BUFFER_STATUS_SUCCESS:
      return "success";
    case ARV_BUFFER_STATUS_CLEARED:
      return "cleared";
    case ARV_BUFFER_STATUS_TIMEOUT:
      return "time-out";
    case ARV_BUFFER_STATUS_MISSING_PACKETS:
      return "missing packets";
    case ARV_BUFFER_STATUS_WRONG_PACKET_ID:
      return "wrong packet id";
    case ARV_BUFFER_STATUS_SIZE_MISMATCH:
      return "size mismatch";
    case ARV_BUFFER_STATUS_FILLING:
      return "filling";
    case ARV_BUFFER_STATUS_ABORTED:
      return "aborted";
    default:
      return "unknown";
  }
}

bool HasImage(ArvBuffer* buffer) {
  switch (arv_buffer_get_payload_type(buffer)) {
    case ARV_BUFFER_PAYLOAD_TYPE_IMAGE:
    case ARV_BUFFER_PAYLOAD_TYPE_EXTENDED_CHUNK_DATA:
    case ARV_BUFFER_PAYLOAD_TYPE_MULTIPART:
      return true;
    default:
      return false;
  }
}

}  // namespace

class GenicamLink::Impl {
 public:
  Impl(const GenicamSettings& settings, CameraHandle camera);
  ~Impl();

  // With its settings made.
  Result<void> Arm();
  Result<void> Run(bool start);
  Result<void> CheckAlive();
  Result<Seconds> SetExposure(Seconds exposure);
  void Drop();
  std::string WhatIsWrong(ArvBuffer* buffer) const;
  Result<GenicamImage> Take(ArvBuffer* buffer, std::map<std::string, int>& bad);
  // What the frame says of itself; empty: it does not.
  std::optional<double> Chunk(ArvBuffer* buffer, const char* chunk) const;

  const GenicamSettings settings_;
  std::atomic<bool> lost_ = false;
  CameraHandle camera_;
  GenicamFeatures features_;
  StreamHandle stream_;  // gone before the camera
  ChunkHandle chunks_;   // null: no frame says anything
  GenicamSetup setup_;
  double exposure_us_ = 0;  // read back; 0: not set yet
};

GenicamLink::Impl::Impl(const GenicamSettings& settings, CameraHandle camera)
    : settings_(settings),
      camera_(std::move(camera)),
      features_(arv_camera_get_device(camera_.get())) {
  ArvDevice* device = arv_camera_get_device(camera_.get());
  // What is read back comes from the camera.
  arv_device_set_register_cache_policy(device, ARV_REGISTER_CACHE_POLICY_DISABLE);
  g_signal_connect(device, "control-lost",
                   G_CALLBACK(+[](ArvDevice*, std::atomic<bool>* lost) { *lost = true; }), &lost_);
}

GenicamLink::Impl::~Impl() {
  // A camera that is gone would be waited for.
  if (stream_ && !lost_) (void)Run(false).ok();
  stream_.reset();
  g_signal_handlers_disconnect_by_data(arv_camera_get_device(camera_.get()), &lost_);
}

Result<void> GenicamLink::Impl::Arm() {
  ArvCamera* camera = camera_.get();
  GError* error = nullptr;
  if (arv_camera_is_gv_device(camera) && settings_.packet_size > 0) {
    arv_camera_gv_set_packet_size_adjustment(camera, ARV_GV_PACKET_SIZE_ADJUSTMENT_NEVER);
    arv_camera_gv_set_packet_size(camera, settings_.packet_size, &error);
    if (error) return GenicamError(error, "packet size");
  }
  stream_.reset(arv_camera_create_stream(camera, nullptr, nullptr, &error));
  if (error || !stream_) return GenicamError(error, "opening the stream");
  if (setup_.tells_exposure || setup_.tells_gain) {
    chunks_.reset(arv_camera_create_chunk_parser(camera));
  }
  const guint payload = arv_camera_get_payload(camera, &error);
  if (error) return GenicamError(error, "PayloadSize");
  if (ARV_IS_GV_STREAM(stream_.get())) {
    const auto bytes = static_cast<gint>(std::clamp<guint>(payload, kSocketBytes, G_MAXINT));
    g_object_set(stream_.get(), "socket-buffer", ARV_GV_STREAM_SOCKET_BUFFER_FIXED,
                 "socket-buffer-size", bytes, nullptr);
  }
  for (int i = 0; i < kBuffers; ++i) {
    arv_stream_push_buffer(stream_.get(), arv_buffer_new_allocate(payload));
  }
  return Run(true);
}

Result<void> GenicamLink::Impl::Run(bool start) {
  GError* error = nullptr;
  if (start) {
    arv_camera_start_acquisition(camera_.get(), &error);
  } else {
    arv_camera_stop_acquisition(camera_.get(), &error);
  }
  if (error) return GenicamError(error, start ? "AcquisitionStart" : "AcquisitionStop");
  return {};
}

Result<void> GenicamLink::Impl::CheckAlive() {
  GError* error = nullptr;
  const ArvPixelFormat format = arv_camera_get_pixel_format(camera_.get(), &error);
  if (error) return GenicamError(error, "PixelFormat");
  gint x = 0;
  gint y = 0;
  gint width = 0;
  gint height = 0;
  arv_camera_get_region(camera_.get(), &x, &y, &width, &height, &error);
  if (error) return GenicamError(error, "Width");
  const auto exposure = features_.Number(setup_.exposure_feature);
  if (!exposure) return exposure.error();
  if (format == setup_.format->code && width == settings_.width && height == settings_.height &&
      (exposure_us_ == 0 || *exposure == exposure_us_)) {
    return {};
  }
  return Error{ErrorCode::kDisconnected, "the camera has forgotten its settings"};
}

Result<Seconds> GenicamLink::Impl::SetExposure(Seconds exposure) {
  const double wanted = exposure.count() / kMicrosecond;
  const std::string& feature = setup_.exposure_feature;
  const auto set = features_.SetNumber(feature, wanted, kExposureTolerance * wanted);
  if (!set) return set.error();
  const auto got = features_.Number(feature);
  if (!got) return got.error();
  exposure_us_ = *got;
  return Seconds(exposure_us_ * kMicrosecond);
}

void GenicamLink::Impl::Drop() {
  while (ArvBuffer* old = arv_stream_try_pop_buffer(stream_.get())) {
    arv_stream_push_buffer(stream_.get(), old);
  }
}

std::string GenicamLink::Impl::WhatIsWrong(ArvBuffer* buffer) const {
  const ArvBufferStatus status = arv_buffer_get_status(buffer);
  if (status != ARV_BUFFER_STATUS_SUCCESS) return NameOf(status);
  if (!HasImage(buffer)) return "no image";
  if (arv_buffer_get_image_pixel_format(buffer) != setup_.format->code) return "pixel format";
  gint x_padding = 0;
  gint y_padding = 0;
  arv_buffer_get_image_padding(buffer, &x_padding, &y_padding);
  std::size_t size = 0;
  // A buffer can come with the status of success and too little in it.
  if (!arv_buffer_get_image_data(buffer, &size) ||
      arv_buffer_get_image_width(buffer) != settings_.width ||
      arv_buffer_get_image_height(buffer) != settings_.height || x_padding != 0 ||
      size < setup_.format->Bytes(setup_.info.counts())) {
    return "size";
  }
  return "";
}

Result<GenicamImage> GenicamLink::Impl::Take(ArvBuffer* buffer, std::map<std::string, int>& bad) {
  if (const std::string wrong = WhatIsWrong(buffer); !wrong.empty()) {
    ++bad[wrong];
    return Error{ErrorCode::kProtocol, "a frame was not whole: " + wrong};
  }
  std::size_t size = 0;
  const auto* data = static_cast<const std::uint8_t*>(arv_buffer_get_image_data(buffer, &size));
  GenicamImage image;
  image.counts.resize(setup_.info.counts());
  UnpackPixels(*setup_.format, std::span(data, size), image.counts);
  const auto exposure =
      setup_.tells_exposure ? Chunk(buffer, "ChunkExposureTime") : std::optional<double>();
  if (exposure) image.exposure = Seconds(*exposure * kMicrosecond);
  if (setup_.tells_gain) image.gain_db = Chunk(buffer, "ChunkGain");
  if (image.exposure || !setup_.tells_exposure) return image;
  ++bad["no exposure time"];
  return Error{ErrorCode::kProtocol, "a frame did not say its exposure time"};
}

std::optional<double> GenicamLink::Impl::Chunk(ArvBuffer* buffer, const char* chunk) const {
  if (!arv_buffer_has_chunks(buffer)) return std::nullopt;
  GError* error = nullptr;
  double value = arv_chunk_parser_get_float_value(chunks_.get(), buffer, chunk, &error);
  if (error &&
      g_error_matches(error, ARV_CHUNK_PARSER_ERROR, ARV_CHUNK_PARSER_ERROR_INVALID_FEATURE_TYPE)) {
    g_clear_error(&error);
    value = static_cast<double>(
        arv_chunk_parser_get_integer_value(chunks_.get(), buffer, chunk, &error));
  }
  const bool told = !error;
  g_clear_error(&error);
  return told ? std::optional(value) : std::nullopt;
}

GenicamLink::GenicamLink(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
GenicamLink::~GenicamLink() = default;

Result<std::unique_ptr<GenicamLink>> GenicamLink::Open(const GenicamSettings& settings) {
  auto camera = Find(settings);
  if (!camera) return camera.error();
  auto impl = std::make_unique<Impl>(settings, std::move(camera).value());
  const auto setup = MakeSettings(settings, impl->camera_.get(), impl->features_);
  if (!setup) return setup.error();
  impl->setup_ = *setup;
  if (const auto armed = impl->Arm(); !armed) return armed.error();
  return std::unique_ptr<GenicamLink>(new GenicamLink(std::move(impl)));
}

const CameraInfo& GenicamLink::info() const { return impl_->setup_.info; }
const std::string& GenicamLink::identity() const { return impl_->setup_.identity; }
double GenicamLink::gain_db() const { return impl_->setup_.gain_db; }
double GenicamLink::black_level() const { return impl_->setup_.black_level; }
bool GenicamLink::tells_exposure() const { return impl_->setup_.tells_exposure; }
void GenicamLink::GiveUp() { impl_->lost_ = true; }
bool GenicamLink::lost() const { return impl_->lost_; }

Result<Seconds> GenicamLink::SetExposure(Seconds exposure) { return impl_->SetExposure(exposure); }
Result<void> GenicamLink::CheckAlive() { return impl_->CheckAlive(); }
void GenicamLink::DropImages() { impl_->Drop(); }
Result<void> GenicamLink::Trigger() { return impl_->features_.Execute("TriggerSoftware"); }

Result<double> GenicamLink::Temperature() {
  const std::string& feature = impl_->setup_.temperature_feature;
  if (feature.empty()) return Refused("DeviceTemperature: the camera has none");
  return impl_->features_.Number(feature);
}

Result<GenicamImage> GenicamLink::WaitForImage(const Deadline& deadline,
                                               const std::function<bool()>& abandoned,
                                               std::map<std::string, int>& bad) {
  do {
    if (abandoned()) return Error{ErrorCode::kCancelled, "the wait for a frame was ended"};
    if (impl_->lost_) return Error{ErrorCode::kDisconnected, "the camera no longer obeys"};
    ArvBuffer* buffer = arv_stream_timeout_pop_buffer(impl_->stream_.get(), kSlice);
    if (!buffer) continue;
    auto image = impl_->Take(buffer, bad);
    arv_stream_push_buffer(impl_->stream_.get(), buffer);
    return image;
  } while (deadline.Left() > Seconds(0));
  ++bad["none"];
  return Error{ErrorCode::kTimeout, "no frame came"};
}

Result<void> GenicamLink::Restart() {
  if (const auto stopped = impl_->Run(false); !stopped) return stopped;
  impl_->Drop();
  return impl_->Run(true);
}

}  // namespace gonio
