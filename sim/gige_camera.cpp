// SPDX-License-Identifier: Apache-2.0
#include "sim/gige_camera.h"

#include <arpa/inet.h>
#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <bit>
#include <condition_variable>
#include <deque>
#include <mutex>
#include <thread>
#include <utility>

#include "sim/gige_control.h"
#include "sim/gige_memory.h"
#include "sim/gige_packing.h"
#include "sim/gige_stream.h"
#include "sim/gige_xml.h"

namespace gonio {
namespace {

using R = GigeRegisters;
constexpr std::uint32_t kFireTest = 0x8000'0000;  // of kPacketSize
constexpr std::uint32_t kSoftware = 1;            // of kTriggerSource

std::uint32_t Number(const std::string& address) {
  in_addr number{};
  inet_pton(AF_INET, address.c_str(), &number);
  return ntohl(number.s_addr);
}

std::uint32_t FloatBits(double value) {
  return std::bit_cast<std::uint32_t>(static_cast<float>(value));
}

const GigeFormat* FindFormat(std::uint32_t code) {
  const auto& formats = GigeFormats();
  const auto found = std::find_if(formats.begin(), formats.end(),
                                  [&](const GigeFormat& known) { return known.code == code; });
  return found == formats.end() ? nullptr : &*found;
}

}  // namespace

class GigeCamera::Impl {
 public:
  Impl(const GigeCameraSettings& settings, GigeExpose expose)
      : settings_(settings), expose_(std::move(expose)), temperature_(settings.temperature_c) {}
  ~Impl() { Stop(); }

  Result<void> Start();
  void Stop();
  void SetPacketLoss(double ratio);
  void SetTemperature(double temperature) { temperature_ = temperature; }
  int exposures() const { return exposures_; }
  bool exposing() const { return exposing_; }

 private:
  void PowerUp();
  // By the control channel's thread.
  void Written(std::uint32_t address);
  void SetAcquiring(bool acquiring);
  UdpPeer Client() const;

  // The exposures' thread: all that follows until the next blank line.
  void Run(std::stop_token stop);
  GigeExposure ReadExposure(const GigeFormat& format);
  // Whether it went to its end.
  bool Wait(Seconds exposure, std::stop_token stop);
  GigeImage Read(const GigeExposure& exposure, const GigeFormat& format);
  void AppendChunks(const GigeExposure& exposure, Bytes& payload) const;

  const GigeCameraSettings settings_;
  const GigeExpose expose_;
  double packet_loss_ = 0;
  std::atomic<double> temperature_;
  std::atomic<int> exposures_ = 0;
  std::atomic<bool> exposing_ = false;
  std::deque<std::uint32_t> coming_exposures_;  // us, of the next late_frames

  std::mutex mutex_;
  std::condition_variable_any changed_;
  bool acquiring_ = false;
  bool triggered_ = false;
  int ended_ = 0;  // how often acquisition has ended

  // While it has power. Threads end before what they use.
  std::unique_ptr<GigeMemory> memory_;
  std::unique_ptr<GigeStream> stream_;
  std::jthread thread_;
  std::unique_ptr<GigeControl> control_;
};

Result<void> GigeCamera::Impl::Start() {
  memory_ = std::make_unique<GigeMemory>(settings_.serial, GigeDescription(settings_));
  PowerUp();
  stream_ = std::make_unique<GigeStream>(settings_.address, settings_.seed);
  stream_->SetLoss(packet_loss_);
  control_ = std::make_unique<GigeControl>(
      settings_.address, *memory_,
      GigeControlHooks{.written = [this](std::uint32_t address) { Written(address); },
                       .abandoned = [this] { SetAcquiring(false); },
                       .resend =
                           [this](std::uint16_t frame, std::uint32_t first, std::uint32_t last) {
                             if (settings_.resends) stream_->Resend(frame, first, last);
                           }});
  if (!control_->ok()) {
    Stop();
    return Error{ErrorCode::kRefused,
                 fmt::format("GigE double: cannot serve at {}: no interface of this machine has "
                             "this address, or its UDP port {} is taken",
                             settings_.address, GigeControl::kPort)};
  }
  thread_ = std::jthread([this](std::stop_token stop) { Run(stop); });
  return {};
}

void GigeCamera::Impl::Stop() {
  control_.reset();
  thread_ = {};
  stream_.reset();
  memory_.reset();
  acquiring_ = triggered_ = false;
}

void GigeCamera::Impl::PowerUp() {
  memory_->Write(R::kAddress, Number(settings_.address));
  const std::uint32_t can = memory_->Read(R::kCapability) & ~R::kCanResend;
  memory_->Write(R::kCapability, can | (settings_.resends ? R::kCanResend : 0));
  memory_->WriteText(R::kVendor, settings_.vendor);
  memory_->WriteText(R::kModel, settings_.model);
  memory_->WriteText(R::kFirmware, settings_.firmware);
  memory_->Write(R::kSensorWidth, settings_.sensor_width);
  memory_->Write(R::kSensorHeight, settings_.sensor_height);
  memory_->Write(R::kWidth, settings_.sensor_width);
  memory_->Write(R::kHeight, settings_.sensor_height);
  // Automatic, as many cameras are until they are told.
  memory_->Write(R::kGainAuto, 1);
  memory_->Write(R::kExposureAuto, 1);
  memory_->Write(R::kTemperature, FloatBits(temperature_));
  coming_exposures_.assign(settings_.late_frames, memory_->Read(R::kExposure));
}

void GigeCamera::Impl::SetPacketLoss(double ratio) {
  packet_loss_ = ratio;
  if (stream_) stream_->SetLoss(ratio);
}

UdpPeer GigeCamera::Impl::Client() const {
  return {memory_->Read(R::kStreamAddress),
          static_cast<std::uint16_t>(memory_->Read(R::kStreamPort))};
}

void GigeCamera::Impl::Written(std::uint32_t address) {
  const std::uint32_t value = memory_->Read(address);
  if (address == R::kAcquisition) SetAcquiring(value == 1);
  if (address == R::kTriggerMode) changed_.notify_all();
  if (address == R::kPacketSize && (value & kFireTest) != 0) {
    memory_->Write(address, value & ~kFireTest);
    stream_->SendTest(Client(), value & 0xFFFF);
  }
  if (address == R::kTriggerSoftware && memory_->Read(R::kTriggerSource) == kSoftware) {
    memory_->Write(address, 0);
    const std::lock_guard lock(mutex_);
    triggered_ = acquiring_ && !exposing_;
    changed_.notify_all();
  }
}

void GigeCamera::Impl::SetAcquiring(bool acquiring) {
  const std::lock_guard lock(mutex_);
  acquiring_ = acquiring;
  triggered_ = false;
  if (!acquiring) ++ended_;
  changed_.notify_all();
}

void GigeCamera::Impl::Run(std::stop_token stop) {
  for (;;) {
    {
      std::unique_lock lock(mutex_);
      const auto due = [&] {
        return acquiring_ && (triggered_ || memory_->Read(R::kTriggerMode) == 0);
      };
      if (!changed_.wait(lock, stop, due)) return;
      triggered_ = false;
      exposing_ = true;
    }
    const GigeFormat* format = FindFormat(memory_->Read(R::kPixelFormat));
    if (format) {
      const GigeExposure exposure = ReadExposure(*format);
      if (Wait(exposure.exposure, stop)) {
        const GigeImage image = Read(exposure, *format);
        memory_->Write(R::kTemperature, FloatBits(temperature_));
        ++exposures_;
        exposing_ = false;
        stream_->Send(image, Client(), memory_->Read(R::kPacketSize) & 0xFFFF);
      }
    }
    exposing_ = false;
  }
}

GigeExposure GigeCamera::Impl::ReadExposure(const GigeFormat& format) {
  coming_exposures_.push_back(memory_->Read(R::kExposure));
  GigeExposure exposure;
  exposure.exposure = Seconds(1e-6 * coming_exposures_.front());
  coming_exposures_.pop_front();
  exposure.gain_db = memory_->Read(R::kGain) / 10.0;
  exposure.black_level = memory_->Read(R::kBlackLevel);
  exposure.x = memory_->Read(R::kOffsetX);
  exposure.y = memory_->Read(R::kOffsetY);
  exposure.width = memory_->Read(R::kWidth);
  exposure.height = memory_->Read(R::kHeight);
  exposure.layout = format.layout;
  exposure.full_scale = (1 << format.bits) - 1;
  exposure.pixel_format = format.name;
  return exposure;
}

bool GigeCamera::Impl::Wait(Seconds exposure, std::stop_token stop) {
  std::unique_lock lock(mutex_);
  // It may have begun again by the time this thread looks.
  const int before = ended_;
  const auto ended = [&] { return !acquiring_ || ended_ != before; };
  return !changed_.wait_for(lock, stop, exposure / settings_.rate, ended) && !stop.stop_requested();
}

GigeImage GigeCamera::Impl::Read(const GigeExposure& exposure, const GigeFormat& format) {
  std::vector<std::uint16_t> counts(exposure.counts());
  expose_(exposure, counts);
  for (std::uint16_t& count : counts) count = std::min<int>(count, exposure.full_scale);
  GigeImage image;
  image.pixel_format = format.code;
  image.x = exposure.x;
  image.y = exposure.y;
  image.width = exposure.width;
  image.height = exposure.height;
  image.payload.resize(counts.size() * format.wire_bits / 8);
  PackCounts(format, counts, image.payload.data());
  image.chunks = settings_.chunks && memory_->Read(R::kChunkMode) == 1;
  if (image.chunks) AppendChunks(exposure, image.payload);
  return image;
}

void GigeCamera::Impl::AppendChunks(const GigeExposure& exposure, Bytes& payload) const {
  EndChunk(payload, 0, GigeChunks::kImage);
  std::uint32_t enabled = R::kChunkEnable;
  for (const auto& [id, value] : {std::pair{GigeChunks::kExposure, 1e6 * exposure.exposure.count()},
                                  std::pair{GigeChunks::kGain, exposure.gain_db}}) {
    const std::size_t begin = payload.size();
    if (memory_->Read(enabled) == 1) {
      PutBigEndian(payload, std::bit_cast<std::uint64_t>(value), GigeChunks::kBytes);
      EndChunk(payload, begin, id);
    }
    enabled += 4;
  }
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
