// SPDX-License-Identifier: Apache-2.0
#include "drivers/apt_codec.h"

#include <fmt/format.h>

#include "core/check.h"
#include "drivers/wire_text.h"

namespace gonio::apt {
namespace {

constexpr std::uint8_t kHasData = 0x80;  // in the byte of the destination

struct Name {
  std::uint16_t id;
  const char* text;
};
constexpr Name kNames[] = {
    {kHwReqInfo, "HW_REQ_INFO"},
    {kHwGetInfo, "HW_GET_INFO"},
    {kHwResponse, "HW_RESPONSE"},
    {kHwRichResponse, "HW_RICHRESPONSE"},
    {kSetChanEnableState, "SET_CHANENABLESTATE"},
    {kSetVelParams, "SET_VELPARAMS"},
    {kReqVelParams, "REQ_VELPARAMS"},
    {kGetVelParams, "GET_VELPARAMS"},
    {kReqStatusBits, "REQ_STATUSBITS"},
    {kGetStatusBits, "GET_STATUSBITS"},
    {kSetGenMoveParams, "SET_GENMOVEPARAMS"},
    {kReqGenMoveParams, "REQ_GENMOVEPARAMS"},
    {kGetGenMoveParams, "GET_GENMOVEPARAMS"},
    {kReqHomeParams, "REQ_HOMEPARAMS"},
    {kGetHomeParams, "GET_HOMEPARAMS"},
    {kMoveHome, "MOVE_HOME"},
    {kMoveHomed, "MOVE_HOMED"},
    {kMoveAbsolute, "MOVE_ABSOLUTE"},
    {kMoveCompleted, "MOVE_COMPLETED"},
    {kMoveStop, "MOVE_STOP"},
    {kMoveStopped, "MOVE_STOPPED"},
    {kReqStatusUpdate, "REQ_STATUSUPDATE"},
    {kGetStatusUpdate, "GET_STATUSUPDATE"},
    {kReqDcStatusUpdate, "REQ_DCSTATUSUPDATE"},
    {kGetDcStatusUpdate, "GET_DCSTATUSUPDATE"},
    {kAckDcStatusUpdate, "ACK_DCSTATUSUPDATE"},
};

struct Bit {
  std::uint32_t bit;
  const char* text;
};
constexpr Bit kFaults[] = {
    {0x4000, "motion error"},          {0x8000, "instrument error"},
    {0x20000, "over-temperature"},     {0x40000, "bus voltage fault"},
    {0x80000, "commutation error"},    {0x2000000, "encoder fault"},
    {0x4000000, "over-current"},       {0x8000000, "current fault"},
    {0x40000000, "unspecified error"},
};

// Bytes with the least significant first.
void Put(std::string* bytes, std::uint32_t value, int count) {
  for (int i = 0; i < count; ++i) *bytes += static_cast<char>((value >> (8 * i)) & 0xff);
}

std::uint32_t At(std::string_view bytes, std::size_t offset, int count) {
  std::uint32_t value = 0;
  for (int i = count - 1; i >= 0; --i) {
    value = value << 8 | static_cast<unsigned char>(bytes[offset + static_cast<std::size_t>(i)]);
  }
  return value;
}

int Word(std::string_view bytes, std::size_t offset) {
  return static_cast<int>(At(bytes, offset, 2));
}
std::int32_t Long(std::string_view bytes, std::size_t offset) {
  return static_cast<std::int32_t>(At(bytes, offset, 4));
}

std::string Words(std::initializer_list<int> words) {
  std::string bytes;
  for (const int word : words) Put(&bytes, static_cast<std::uint32_t>(word), 2);
  return bytes;
}
std::string Longs(std::initializer_list<std::int32_t> longs) {
  std::string bytes;
  for (const std::int32_t value : longs) Put(&bytes, static_cast<std::uint32_t>(value), 4);
  return bytes;
}

// Up to the first NUL, as text of a fixed length is filled up.
std::string_view Text(std::string_view bytes) { return bytes.substr(0, bytes.find('\0')); }

Message WithData(Id id, int module, std::string data) {
  Message message;
  message.id = id;
  message.dest = module;
  message.data = std::move(data);
  return message;
}

// Its data, if that is as long as a message of this kind has it.
Result<std::string_view> DataOf(const Message& message, std::uint16_t id, std::size_t size) {
  if (message.id != id || !message.data || message.data->size() != size) {
    return Error{ErrorCode::kProtocol,
                 fmt::format("{} with {} bytes of data is no {} with {}", NameOf(message.id),
                             message.data ? message.data->size() : 0, NameOf(id), size)};
  }
  return std::string_view(*message.data);
}

}  // namespace

std::string NameOf(std::uint16_t id) {
  for (const Name& name : kNames) {
    if (name.id == id) return name.text;
  }
  return fmt::format("message 0x{:04x}", id);
}

std::string Encode(const Message& message) {
  std::string bytes;
  Put(&bytes, message.id, 2);
  if (message.data) {
    GONIO_CHECK(message.data->size() <= kMostData, "data fits into a message");
    Put(&bytes, static_cast<std::uint32_t>(message.data->size()), 2);
  } else {
    Put(&bytes, message.p1, 1);
    Put(&bytes, message.p2, 1);
  }
  Put(&bytes, static_cast<std::uint32_t>(message.dest) | (message.data ? kHasData : 0u), 1);
  Put(&bytes, static_cast<std::uint32_t>(message.source), 1);
  return message.data ? bytes + *message.data : bytes;
}

Result<std::optional<Message>> TakeMessage(std::string* bytes) {
  if (bytes->size() < kHeaderBytes) return std::optional<Message>();
  const std::string_view all = *bytes;
  Message message;
  message.id = static_cast<std::uint16_t>(At(all, 0, 2));
  const std::uint32_t dest = At(all, 4, 1);
  message.dest = static_cast<int>(dest & ~std::uint32_t{kHasData});
  message.source = static_cast<int>(At(all, 5, 1));
  const bool has_data = (dest & kHasData) != 0;
  const std::size_t size = has_data ? At(all, 2, 2) : 0;
  const bool of_controller = message.source == kRack || message.source == kUsbUnit ||
                             (message.source >= kFirstBay && message.source <= kLastBay);
  if (message.dest != kHost || !of_controller || size > kMostData) {
    return Error{ErrorCode::kProtocol, fmt::format("{} is no message of an APT controller",
                                                   Quoted(all.substr(0, kHeaderBytes)))};
  }
  if (all.size() < kHeaderBytes + size) return std::optional<Message>();
  if (has_data) {
    message.data = all.substr(kHeaderBytes, size);
  } else {
    message.p1 = static_cast<std::uint8_t>(At(all, 2, 1));
    message.p2 = static_cast<std::uint8_t>(At(all, 3, 1));
  }
  bytes->erase(0, kHeaderBytes + size);
  return std::optional(std::move(message));
}

// Messages of a motor are numbered 0x04.. .
std::optional<int> ChannelOf(const Message& message) {
  if (message.id >> 8 != 0x04) return std::nullopt;
  if (!message.data) return message.p1;
  if (message.data->size() < 2) return std::nullopt;
  return Word(*message.data, 0);
}

Message AboutMotor(Id id, const Address& address, int p2) {
  Message message;
  message.id = id;
  message.dest = address.module;
  message.p1 = static_cast<std::uint8_t>(address.channel);
  message.p2 = static_cast<std::uint8_t>(p2);
  return message;
}

Message MoveTo(const Address& address, std::int32_t position) {
  return WithData(kMoveAbsolute, address.module, Words({address.channel}) + Longs({position}));
}

Message SetVelocity(int module, const Velocity& velocity) {
  return WithData(
      kSetVelParams, module,
      Words({velocity.channel}) + Longs({velocity.least, velocity.acceleration, velocity.most}));
}

Message SetBacklash(int module, const Backlash& backlash) {
  return WithData(kSetGenMoveParams, module,
                  Words({backlash.channel}) + Longs({backlash.distance}));
}

Result<Velocity> DecodeVelocity(const Message& message) {
  const Result<std::string_view> data = DataOf(message, kGetVelParams, 14);
  if (!data) return data.error();
  return Velocity{.channel = Word(*data, 0),
                  .least = Long(*data, 2),
                  .acceleration = Long(*data, 6),
                  .most = Long(*data, 10)};
}

Result<Backlash> DecodeBacklash(const Message& message) {
  const Result<std::string_view> data = DataOf(message, kGetGenMoveParams, 6);
  if (!data) return data.error();
  return Backlash{.channel = Word(*data, 0), .distance = Long(*data, 2)};
}

Result<Homing> DecodeHoming(const Message& message) {
  const Result<std::string_view> data = DataOf(message, kGetHomeParams, 14);
  if (!data) return data.error();
  return Homing{.channel = Word(*data, 0),
                .direction = Word(*data, 2),
                .limit_switch = Word(*data, 4),
                .velocity = Long(*data, 6),
                .offset = Long(*data, 10)};
}

Result<Info> DecodeInfo(const Message& message) {
  const Result<std::string_view> data = DataOf(message, kHwGetInfo, 84);
  if (!data) return data.error();
  const std::string quoted = Quoted(Text(data->substr(4, 8)));
  return Info{
      .serial = Long(*data, 0),
      .model = quoted.substr(1, quoted.size() - 2),
      .firmware = fmt::format("{}.{}.{}", At(*data, 16, 1), At(*data, 15, 1), At(*data, 14, 1))};
}

Result<Status> DecodeStatus(const Message& message) {
  const bool servo = message.id == kGetDcStatusUpdate;
  const auto data = DataOf(message, servo ? kGetDcStatusUpdate : kGetStatusUpdate, 14);
  if (!data) return data.error();
  return Status{.channel = Word(*data, 0), .position = Long(*data, 2), .bits = At(*data, 10, 4)};
}

std::string FaultsIn(std::uint32_t bits) {
  std::string text;
  for (const Bit& fault : kFaults) {
    if ((bits & fault.bit) == 0) continue;
    if (!text.empty()) text += ", ";
    text += fault.text;
  }
  return text;
}

std::optional<Report> ReportIn(const Message& message) {
  if (message.id == kHwResponse) return Report{.about = 0, .text = "an error it does not name"};
  const auto data = DataOf(message, kHwRichResponse, 68);
  if (!data) return std::nullopt;
  return Report{
      .about = static_cast<std::uint16_t>(At(*data, 0, 2)),
      .text = fmt::format("error {}: {}", At(*data, 2, 2), Quoted(Text(data->substr(4))))};
}

}  // namespace gonio::apt
