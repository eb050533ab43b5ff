// SPDX-License-Identifier: Apache-2.0
#include "sim/usb_host.h"

#include <algorithm>
#include <cerrno>
#include <utility>

namespace gonio {
namespace {

// The only interface that anybody wants.
constexpr unsigned kInterface = 1;
constexpr std::size_t kSetupBytes = 8;
constexpr std::uint8_t kGetDescriptor = 6;
constexpr int kText = 3;

UsbSetup SetupIn(const std::string& bytes) {
  const auto at = [&](std::size_t i) { return static_cast<std::uint8_t>(bytes[i]); };
  const auto word = [&](std::size_t i) {
    return static_cast<std::uint16_t>(at(i) | at(i + 1) << 8);
  };
  return {at(0), at(1), word(2), word(4), word(6)};
}

// The text of a number, as all devices give it: length, kind, UTF-16.
std::string TextDescriptor(const UsbPlate& plate, int number) {
  std::string units;
  const std::string& text = number == 1   ? plate.maker
                            : number == 2 ? plate.description
                                          : plate.serial;
  for (const char c : text) units += std::string{c, '\0'};
  if (number == 0) units = {0x09, 0x04};  // English
  return std::string{static_cast<char>(units.size() + 2), kText} + units;
}

}  // namespace

int UsbHost::Claim(Program program, unsigned interface, bool drop_system_driver) {
  const std::lock_guard lock(mutex_);
  if (out_) return ENODEV;
  if (interface != kInterface) return ENOENT;
  if (owner_ != nullptr && owner_ != program) return EBUSY;
  if (system_driver_ && !drop_system_driver) return EBUSY;
  system_driver_ = false;
  owner_ = program;
  return 0;
}

int UsbHost::Release(Program program, unsigned interface) {
  const std::lock_guard lock(mutex_);
  if (out_) return ENODEV;
  if (interface != kInterface || owner_ != program) return EINVAL;
  owner_ = nullptr;
  return 0;
}

int UsbHost::ReleaseAll(Program program) {
  const std::lock_guard lock(mutex_);
  if (owner_ == program) owner_ = nullptr;
  under_way_.remove_if([program](const UnderWay& t) { return t.program == program; });
  return 0;
}

int UsbHost::DetachSystemDriver(unsigned interface) {
  const std::lock_guard lock(mutex_);
  if (out_) return ENODEV;
  if (interface != kInterface || !system_driver_) return ENODATA;
  system_driver_ = false;
  return 0;
}

int UsbHost::AttachSystemDriver(unsigned interface) {
  const std::lock_guard lock(mutex_);
  if (out_) return ENODEV;
  if (interface != kInterface || owner_ != nullptr) return EBUSY;
  system_driver_ = true;
  return 0;
}

std::string UsbHost::DriverOf(unsigned interface) const {
  const std::lock_guard lock(mutex_);
  if (interface != kInterface) return {};
  return system_driver_ ? "usbtmc" : owner_ != nullptr ? "usbfs" : "";
}

int UsbHost::ClearHalt(std::uint8_t endpoint) {
  const std::lock_guard lock(mutex_);
  if (out_) return ENODEV;
  device_->ClearHalt(endpoint);
  return 0;
}

int UsbHost::Reset() {
  const std::lock_guard lock(mutex_);
  if (out_) return ENODEV;
  device_->Reset();
  return 0;
}

// Interfaces belong to who has claimed them; questions to the device as a whole are free.
bool UsbHost::MayUse(Program program, const Transfer& transfer) const {
  constexpr int kRecipient = 0x1f;
  if (transfer.kind == Transfer::Kind::kControl && (transfer.bytes[0] & kRecipient) == 0) {
    return true;
  }
  return owner_ == program;
}

int UsbHost::Submit(Program program, Ticket ticket, Transfer transfer) {
  const std::lock_guard lock(mutex_);
  if (out_) return ENODEV;
  const bool whole =
      transfer.kind != Transfer::Kind::kControl || transfer.bytes.size() >= kSetupBytes;
  if (!whole || !MayUse(program, transfer)) return EINVAL;
  under_way_.push_back({program, ticket, std::move(transfer), std::nullopt});
  Try(&under_way_.back());
  return 0;
}

int UsbHost::Cancel(Ticket ticket) {
  const std::lock_guard lock(mutex_);
  for (UnderWay& t : under_way_) {
    if (t.ticket != ticket || t.ended) continue;
    t.ended = Ended{.ticket = ticket, .status = -ENOENT, .bytes = {}, .sent = 0};
    return 0;
  }
  return EINVAL;
}

int UsbHost::Reap(Program program, Ended* ended) {
  const std::lock_guard lock(mutex_);
  for (auto t = under_way_.begin(); t != under_way_.end(); ++t) {
    if (t->program != program) continue;
    if (!t->ended) Try(&*t);
    if (!t->ended) continue;
    *ended = *std::move(t->ended);
    under_way_.erase(t);
    return 0;
  }
  return out_ ? ENODEV : EAGAIN;
}

void UsbHost::Try(UnderWay* t) {
  const Transfer& transfer = t->transfer;
  const bool in = (transfer.endpoint & 0x80) != 0;
  UsbOutcome outcome = transfer.kind == Transfer::Kind::kControl ? Control(transfer)
                       : in                                      ? device_->In(transfer.room)
                                                                 : device_->Out(transfer.bytes);
  if (outcome.kind == UsbOutcome::Kind::kLater) return;
  Ended ended{.ticket = t->ticket, .status = 0, .bytes = std::move(outcome.bytes), .sent = 0};
  if (outcome.kind == UsbOutcome::Kind::kStalled) {
    ended.status = -EPIPE;
  } else if (ended.bytes.size() > transfer.room) {
    ended.status = -EOVERFLOW;
    ended.bytes.resize(transfer.room);
  } else if (transfer.kind == Transfer::Kind::kBulk && !in) {
    ended.sent = transfer.bytes.size();
  }
  t->ended = std::move(ended);
}

UsbOutcome UsbHost::Control(const Transfer& transfer) {
  const UsbSetup setup = SetupIn(transfer.bytes);
  if (setup.type != 0x80) return device_->Control(setup);
  if (setup.request != kGetDescriptor || setup.value >> 8 != kText) {
    return {UsbOutcome::Kind::kStalled, {}};
  }
  return {UsbOutcome::Kind::kDone,
          TextDescriptor(device_->plate(), setup.value & 0xff).substr(0, setup.length)};
}

void UsbHost::TakeOut() {
  const std::lock_guard lock(mutex_);
  out_ = true;
  for (UnderWay& t : under_way_) {
    t.ended = Ended{.ticket = t.ticket, .status = -ESHUTDOWN, .bytes = {}, .sent = 0};
  }
}

bool UsbHost::is_out() const {
  const std::lock_guard lock(mutex_);
  return out_;
}

}  // namespace gonio
