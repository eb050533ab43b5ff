// SPDX-License-Identifier: Apache-2.0
#include "sim/gige_camera.h"

#include <arv.h>
#include <fmt/format.h>
#include <stdlib.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <bit>
#include <condition_variable>
#include <cstdio>
#include <cstring>
#include <mutex>
#include <utility>

#include "sim/gige_packing.h"
#include "sim/gige_xml.h"

namespace gonio {
namespace {

using R = GigeRegisters;
constexpr double kLongestExposure = 1.5;  // s of the machine's
// Triggers are looked for so often [1/s]: more keeps a core busy, less delays frames.
constexpr double kTriggerFrequency = 500;

struct Unref {
  void operator()(void* object) const { g_object_unref(object); }
};
using FakeCamera = std::unique_ptr<ArvGvFakeCamera, Unref>;

// A text as a file, for as long as it lives: the fake camera reads its description from one.
class TextFile {
 public:
  explicit TextFile(const std::string& text) {
    const int file = mkstemp(path_);
    GONIO_CHECK(file >= 0, "no temporary file");
    FILE* stream = fdopen(file, "w");
    GONIO_CHECK(stream && std::fputs(text.c_str(), stream) >= 0 && std::fclose(stream) == 0,
                "cannot write a temporary file");
  }
  ~TextFile() { unlink(path_); }
  TextFile(const TextFile&) = delete;
  TextFile& operator=(const TextFile&) = delete;
  const char* path() const { return path_; }

 private:
  char path_[sizeof "/tmp/gonio-gige-XXXXXX"] = "/tmp/gonio-gige-XXXXXX";
};

}  // namespace

class GigeCamera::Impl {
 public:
  Impl(const GigeCameraSettings& settings, GigeExpose expose)
      : settings_(settings), expose_(std::move(expose)), temperature_(settings.temperature_c) {
    g_random_set_seed(settings.seed);
  }
  ~Impl() { Stop(); }

  Result<void> Start();
  void Stop();
  void SetPacketLoss(double ratio);
  void SetTemperature(double temperature) { temperature_ = temperature; }
  int exposures() const { return exposures_; }
  bool exposing() const { return exposing_; }

 private:
  static void Fill(ArvBuffer* buffer, void* self, guint32, guint32, ArvPixelFormat) {
    static_cast<Impl*>(self)->Expose(buffer);
  }
  void Expose(ArvBuffer* buffer);
  void Wait(Seconds exposure);
  ArvFakeCamera* registers() const { return registers_; }
  std::uint32_t Read(std::uint32_t address) const;
  void Write(std::uint32_t address, std::uint32_t value);
  void Write(std::uint32_t address, const std::string& text);
  void PowerUp();

  const GigeCameraSettings settings_;
  const GigeExpose expose_;
  FakeCamera camera_;
  ArvFakeCamera* registers_ = nullptr;  // of camera_
  double packet_loss_ = 0;
  std::atomic<double> temperature_;
  std::atomic<int> exposures_ = 0;
  std::atomic<bool> exposing_ = false;
  std::vector<std::uint16_t> counts_;

  std::mutex mutex_;
  std::condition_variable stopped_;
  bool stopping_ = false;
};

Result<void> GigeCamera::Impl::Start() {
  const TextFile description(GigeDescription(settings_));
  stopping_ = false;
  FakeCamera camera(arv_gv_fake_camera_new_full(settings_.address.c_str(), settings_.serial.c_str(),
                                                description.path()));
  if (!arv_gv_fake_camera_is_running(camera.get())) {
    return Error{ErrorCode::kRefused,
                 fmt::format("GigE double: cannot serve at {}: no interface of this machine has "
                             "this address, or its UDP port 3956 is taken",
                             settings_.address)};
  }
  camera_ = std::move(camera);
  registers_ = arv_gv_fake_camera_get_fake_camera(camera_.get());
  PowerUp();
  SetPacketLoss(packet_loss_);
  arv_fake_camera_set_trigger_frequency(registers_, kTriggerFrequency);
  arv_fake_camera_set_fill_pattern(registers_, &Impl::Fill, this);
  return {};
}

void GigeCamera::Impl::Stop() {
  {
    const std::lock_guard lock(mutex_);
    stopping_ = true;
  }
  stopped_.notify_all();
  camera_.reset();
  registers_ = nullptr;
}

void GigeCamera::Impl::PowerUp() {
  Write(R::kVendor, settings_.vendor);
  Write(R::kModel, settings_.model);
  Write(R::kFirmware, settings_.firmware);
  Write(R::kSensorWidth, settings_.sensor_width);
  Write(R::kSensorHeight, settings_.sensor_height);
  Write(R::kWidth, settings_.sensor_width);
  Write(R::kHeight, settings_.sensor_height);
  // Automatic, as many cameras are until they are told.
  Write(R::kGainAuto, 1);
  Write(R::kExposureAuto, 1);
  Write(R::kTemperature, std::bit_cast<std::uint32_t>(static_cast<float>(temperature_)));
}

void GigeCamera::Impl::SetPacketLoss(double ratio) {
  packet_loss_ = ratio;
  if (camera_) g_object_set(camera_.get(), "gvsp-lost-ratio", ratio, nullptr);
}

std::uint32_t GigeCamera::Impl::Read(std::uint32_t address) const {
  guint32 value = 0;
  arv_fake_camera_read_register(registers_, address, &value);
  return value;
}

void GigeCamera::Impl::Write(std::uint32_t address, std::uint32_t value) {
  arv_fake_camera_write_register(registers_, address, value);
}

void GigeCamera::Impl::Write(std::uint32_t address, const std::string& text) {
  char field[32] = {};
  std::strncpy(field, text.c_str(), sizeof field - 1);
  arv_fake_camera_write_memory(registers_, address, sizeof field, field);
}

void GigeCamera::Impl::Wait(Seconds exposure) {
  const Seconds time(std::min(exposure.count() / settings_.rate, kLongestExposure));
  std::unique_lock lock(mutex_);
  exposing_ = true;
  stopped_.wait_for(lock, time, [&] { return stopping_; });
  exposing_ = false;
}

void GigeCamera::Impl::Expose(ArvBuffer* buffer) {
  GigeExposure exposure;
  exposure.exposure = Seconds(1e-6 * Read(R::kExposure));
  exposure.gain_db = Read(R::kGain) / 10.0;
  exposure.black_level = Read(R::kBlackLevel);
  exposure.x = Read(R::kOffsetX);
  exposure.y = Read(R::kOffsetY);
  exposure.width = Read(R::kWidth);
  exposure.height = Read(R::kHeight);
  const auto& formats = GigeFormats();
  const std::uint32_t code = Read(R::kPixelFormat);
  const auto format = std::find_if(formats.begin(), formats.end(),
                                   [&](const GigeFormat& known) { return known.code == code; });
  if (format == formats.end()) return;
  exposure.layout = format->layout;
  exposure.full_scale = (1 << format->bits) - 1;
  exposure.pixel_format = format->name;

  Wait(exposure.exposure);
  counts_.assign(exposure.counts(), 0);
  expose_(exposure, counts_);
  for (std::uint16_t& count : counts_) count = std::min<int>(count, exposure.full_scale);
  // The buffer's own word for its size is 0 here; it has what the payload says.
  size_t unused = 0;
  const void* data = arv_buffer_get_data(buffer, &unused);
  PackCounts(*format, counts_, static_cast<std::uint8_t*>(const_cast<void*>(data)));
  Write(R::kTemperature, std::bit_cast<std::uint32_t>(static_cast<float>(temperature_)));
  ++exposures_;
}

GigeCamera::GigeCamera(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
GigeCamera::~GigeCamera() = default;

Result<std::unique_ptr<GigeCamera>> GigeCamera::Serve(const GigeCameraSettings& settings,
                                                      GigeExpose expose) {
  auto impl = std::make_unique<Impl>(settings, std::move(expose));
  if (const auto started = impl->Start(); !started) return started.error();
  return std::unique_ptr<GigeCamera>(new GigeCamera(std::move(impl)));
}

void GigeCamera::SetPacketLoss(double ratio) { impl_->SetPacketLoss(ratio); }
void GigeCamera::SetTemperature(double temperature_c) { impl_->SetTemperature(temperature_c); }
void GigeCamera::Disappear() { impl_->Stop(); }
Result<void> GigeCamera::Return() { return impl_->Start(); }
int GigeCamera::exposures() const { return impl_->exposures(); }
bool GigeCamera::exposing() const { return impl_->exposing(); }

}  // namespace gonio
