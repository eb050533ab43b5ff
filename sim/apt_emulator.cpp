// SPDX-License-Identifier: Apache-2.0
#include "sim/apt_emulator.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <utility>

#include "core/error.h"
#include "core/units.h"

namespace gonio {
namespace {

constexpr double kTop = 40;           // deg/s
constexpr double kAcceleration = 80;  // deg/s^2
constexpr int kPatience = 50;         // statuses that it sends without hearing from anybody
constexpr std::uint8_t kRackAddress = 0x11;

// Values as they lie in memory: these machines and ours are little-endian.
template <typename T>
std::string Raw(T value) {
  std::string bytes(sizeof value, '\0');
  std::memcpy(bytes.data(), &value, sizeof value);
  return bytes;
}
template <typename T>
T Read(std::string_view bytes, std::size_t offset) {
  T value{};
  if (offset + sizeof value <= bytes.size()) {
    std::memcpy(&value, bytes.data() + offset, sizeof value);
  }
  return value;
}
std::string Padded(std::string_view text, std::size_t size) {
  std::string bytes(size, '\0');
  text.copy(bytes.data(), size);
  return bytes;
}

}  // namespace

AptStage K10cr1() {
  AptStage stage;
  stage.servo = false;
  stage.serial = 55000123;
  stage.model = "K10CR1";
  stage.counts_per_deg = 136533.33;
  stage.velocity_units = 136533.33 * 53.68;
  stage.acceleration_units = 136533.33 / 90.9;
  stage.homing_velocity = 73291080;
  stage.backlash = 136533;
  return stage;
}

AptStage AptStageOf(const std::string& name) {
  if (name == "PRM1-Z8") return {};
  if (name == "K10CR1") return K10cr1();
  AptStage stage;
  if (name == "DDR100" || name == "DDR05") {
    const bool large = name == "DDR100";
    stage.serial = 28000042;
    stage.model = "KBD101";
    stage.counts_per_deg = large ? 9102.22 : 5555.55;
    stage.velocity_units = large ? 61083.98 : 37282.7;
    stage.acceleration_units = large ? 6.255 : 3.818;
  } else if (name == "HDR50" || name == "NR360") {
    stage.servo = false;
    stage.serial = 40000042;
    stage.model = "BSC201";
    stage.counts_per_deg = 75091 / 0.99997;
    stage.velocity_units = 4030885 / 0.99997;
    stage.acceleration_units = 826 / 0.99997;
  } else {
    throw ConfigError(name + ": no stage that is emulated");
  }
  stage.homing_velocity = static_cast<std::int32_t>(10 * stage.velocity_units);
  stage.backlash = static_cast<std::int32_t>(stage.counts_per_deg);
  return stage;
}

struct AptEmulator::Header {
  std::uint16_t id;
  std::uint8_t p1;
  std::uint8_t p2;
  std::uint8_t dest;
  std::uint8_t source;
};

AptEmulator::AptEmulator(const AptStage& stage, std::shared_ptr<Clock> clock)
    : stage_(stage),
      clock_(std::move(clock)),
      motor_(RadFromDeg(stage.switched_on_at_deg), RadFromDeg(kTop), RadFromDeg(kAcceleration),
             *clock_) {
  PowerOn();
}

void AptEmulator::PowerOn() {
  motor_.Stop();
  counter_zero_ = motor_.Position();
  homed_ = homing_ = moving_ = at_switch_ = false;
  enabled_ = true;
  velocity_ = static_cast<std::int32_t>(10 * stage_.velocity_units);
  acceleration_ = static_cast<std::int32_t>(10 * stage_.acceleration_units);
  backlash_ = stage_.backlash;
  faults_ = more_bits_ = 0;
}

std::string AptEmulator::Receive(std::string_view bytes) {
  const std::lock_guard lock(mutex_);
  pending_ += bytes;
  std::string said = Unasked();
  while (pending_.size() >= sizeof(Header)) {
    const auto header = Read<Header>(pending_, 0);
    const bool has_data = (header.dest & 0x80) != 0;
    const std::size_t size = has_data ? Read<std::uint16_t>(pending_, 2) : 0;
    if (pending_.size() < sizeof(Header) + size) break;
    const std::string data = pending_.substr(sizeof(Header), size);
    pending_.erase(0, sizeof(Header) + size);
    const std::uint8_t dest = header.dest & 0x7f;
    const bool asks_rack = dest == kRackAddress && stage_.module != 0x50;
    if (dest == stage_.module || asks_rack) said += Obey(header, data);
  }
  return said;
}

std::string AptEmulator::Unasked() {
  std::string said;
  if (moving_ && !motor_.Moving()) {
    moving_ = false;
    said += Status(0x0464);
  }
  if (homing_ && !motor_.Moving()) {
    homing_ = false;
    homed_ = true;
    counter_zero_ = 0;
    said += Raw(std::uint16_t{0x0444}) + Raw(stage_.channel) + Raw(std::uint8_t{0}) +
            Raw(std::uint8_t{1}) + Raw(stage_.module);
  }
  if (chatter_) said += Status(stage_.servo ? 0x0491 : 0x0481);
  return said;
}

std::string AptEmulator::Obey(const Header& header, std::string_view data) {
  if (header.id == 0x0492 && stage_.servo) {
    unacknowledged_ = 0;
    return {};
  }
  const bool has_data = (header.dest & 0x80) != 0;
  const int channel = has_data ? Read<std::uint16_t>(data, 0) : header.p1;
  if (header.id != 0x0005 && channel != stage_.channel) return {};
  if (!complaint_.empty() && complained_of_ == header.id) return std::exchange(complaint_, {});
  if (Set(header, data) || Move(header, data)) return {};
  if (header.id == 0x0465) {
    if (!motor_.Moving()) return {};
    Halt();
    return Status(0x0466);
  }
  std::string answer = Get(header);
  if (answer.empty()) answer = HwResponse();
  return complained_of_ == 0 ? std::exchange(complaint_, {}) + answer : answer;
}

// The answer, if it is a question it knows; and nothing where it has given up.
std::string AptEmulator::Get(const Header& header) {
  const std::string channel = Raw(std::uint16_t{stage_.channel});
  const std::int32_t zero = 0;
  switch (header.id) {
    case 0x0005: {
      const bool card = stage_.module != 0x50 && header.dest == stage_.module;
      return Long(0x0006,
                  Raw(card ? std::int32_t{-1} : stage_.serial) + Padded(stage_.model, 8) +
                      Raw(std::uint16_t{16}) + Padded("\x03\x01\x02", 4) +
                      Padded("rotary stage", 48) + Padded("", 12) + Raw(std::uint16_t{1}) +
                      Raw(std::uint16_t{0}) + Raw(std::uint16_t{1}),
                  header.dest);
    }
    case 0x0414:
      return Long(0x0415, channel + Raw(zero) + Raw(acceleration_) + Raw(velocity_));
    case 0x0429:
      return Long(0x042a, channel + Raw(Bits()));
    case 0x043b:
      return Long(0x043c, channel + Raw(backlash_));
    case 0x0441:
      return Long(0x0442, channel + Raw(std::uint16_t{2}) + Raw(std::uint16_t{1}) +
                              Raw(stage_.homing_velocity) + Raw(zero));
    case 0x0480:
      return stage_.servo ? "" : Status(0x0481);
    case 0x0490:
      return stage_.servo ? Status(0x0491) : "";
    default:
      return {};
  }
}

bool AptEmulator::Set(const Header& header, std::string_view data) {
  const auto most = static_cast<std::int32_t>(stage_.fastest_deg_s * stage_.velocity_units);
  switch (header.id) {
    case 0x0210:
      enabled_ = header.p2 == 1;
      return true;
    case 0x0413:
      acceleration_ = Read<std::int32_t>(data, 6);
      velocity_ = std::min(Read<std::int32_t>(data, 10), most);
      return true;
    case 0x043a:
      backlash_ = Read<std::int32_t>(data, 2);
      return true;
    default:
      return false;
  }
}

bool AptEmulator::Move(const Header& header, std::string_view data) {
  if (header.id != 0x0443 && header.id != 0x0453) return false;
  if (!enabled_) return true;
  Halt();
  if (header.id == 0x0443) {
    faults_ = 0;
    was_homed_ = homed_;
    homed_ = homed_ && stage_.keeps_homed;
    at_switch_ = false;
    homing_ = true;
    Start(0, stage_.homing_velocity / stage_.velocity_units);
    return true;
  }
  const double deg =
      DegFromRad(counter_zero_) + Read<std::int32_t>(data, 2) / stage_.counts_per_deg;
  at_switch_ = deg > stage_.switch_at_deg;
  moving_ = true;
  Start(std::min(deg, stage_.switch_at_deg), velocity_ / stage_.velocity_units);
  return true;
}

void AptEmulator::Start(double deg, double deg_s) {
  backwards_ = RadFromDeg(deg) < motor_.Position();
  started_ = clock_->Now();
  motor_.Start(RadFromDeg(deg), deg_s / kTop);
}

void AptEmulator::Halt() {
  motor_.Stop();
  homing_ = moving_ = false;
}

std::int32_t AptEmulator::Counter() const {
  return static_cast<std::int32_t>(
      std::lround(DegFromRad(motor_.Position() - counter_zero_) * stage_.counts_per_deg));
}

std::uint32_t AptEmulator::Bits() const {
  std::uint32_t bits = 0x100 | faults_ | more_bits_;
  const bool shown = clock_->Now() - started_ >= stage_.sluggish;
  if (motor_.Moving() && shown) bits |= backwards_ ? 0x20 : 0x10;
  if (homing_ && shown) bits |= 0x200;
  if (homed_ || (homing_ && was_homed_ && !shown)) bits |= 0x400;
  if (at_switch_ && !motor_.Moving()) bits |= 0x1;
  if (enabled_) bits |= 0x80000000;
  return bits;
}

// MOVE_COMPLETED and MOVE_STOPPED are made the same way.
std::string AptEmulator::Status(std::uint16_t id) {
  if (stage_.servo && ++unacknowledged_ > kPatience) return {};
  const std::string between =
      stage_.servo ? Raw(std::int16_t{0}) + Raw(std::uint16_t{0}) : Raw(std::int32_t{0});
  return Long(id, Raw(std::uint16_t{stage_.channel}) + Raw(Counter()) + between + Raw(Bits()));
}

std::string AptEmulator::Long(std::uint16_t id, const std::string& data, int source) const {
  const auto from = static_cast<std::uint8_t>(source == 0 ? stage_.module : source);
  return Raw(id) + Raw(static_cast<std::uint16_t>(data.size())) + Raw(std::uint8_t{0x81}) +
         Raw(from) + data;
}

std::string AptEmulator::HwResponse() const {
  return Raw(std::uint16_t{0x0080}) + Raw(std::uint16_t{0}) + Raw(std::uint8_t{1}) +
         Raw(stage_.module);
}

std::int32_t AptEmulator::backlash() const {
  const std::lock_guard lock(mutex_);
  return backlash_;
}

std::int32_t AptEmulator::max_velocity() const {
  const std::lock_guard lock(mutex_);
  return velocity_;
}

void AptEmulator::Reset() {
  const std::lock_guard lock(mutex_);
  PowerOn();
}

void AptEmulator::CutMotorPower() {
  const std::lock_guard lock(mutex_);
  Halt();
  enabled_ = false;
}

void AptEmulator::Fail(std::uint32_t bits) {
  const std::lock_guard lock(mutex_);
  Halt();
  faults_ = bits;
}

void AptEmulator::SetBits(std::uint32_t bits) {
  const std::lock_guard lock(mutex_);
  more_bits_ = bits;
}

void AptEmulator::Complain(std::uint16_t about, std::uint16_t code, const std::string& notes) {
  const std::lock_guard lock(mutex_);
  complained_of_ = about;
  complaint_ = Long(0x0081, Raw(about) + Raw(code) + Padded(notes, 64));
}

void AptEmulator::Complain() {
  const std::lock_guard lock(mutex_);
  complained_of_ = 0;
  complaint_ = HwResponse();
}

void AptEmulator::Chatter() {
  const std::lock_guard lock(mutex_);
  chatter_ = true;
}

}  // namespace gonio
