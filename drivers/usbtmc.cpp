// SPDX-License-Identifier: Apache-2.0
#include "drivers/usbtmc.h"

#include <fmt/format.h>

#include <algorithm>
#include <thread>
#include <utility>

#include "drivers/deadline.h"

namespace gonio {

using usbtmc::Request;
using usbtmc::Status;

namespace {

constexpr UsbClass kUsbtmc{.code = 0xfe, .subclass = 0x03, .what = "USB test and measurement"};

// Payload of one transfer. What the system's own driver uses, so what devices are tried with.
constexpr std::size_t kTransferBytes = 4096;

constexpr Seconds kRequestLimit{0.5};
constexpr Seconds kReadAwayLimit{0.3};  // until a device has nothing more to say
constexpr int kMostReadAway = 100;      // transfers
constexpr Seconds kPollInterval{0.05};  // between two questions whether it is done

}  // namespace

struct UsbtmcDevice::Part {
  std::string payload;
  bool last = false;
};

Result<std::vector<UsbDeviceInfo>> ListUsbtmcDevices() { return UsbInterface::List(kUsbtmc); }

Result<std::unique_ptr<UsbtmcDevice>> UsbtmcDevice::Open(const UsbSelection& selection) {
  auto usb = UsbInterface::Open(selection, kUsbtmc);
  if (!usb) return usb.error();
  constexpr std::uint16_t kCapabilityBytes = 0x18;
  const auto reply = (*usb)->Ask(static_cast<std::uint8_t>(Request::kGetCapabilities), 0,
                                 UsbInterface::About::kInterface, kCapabilityBytes, kRequestLimit);
  if (!reply) return reply.error();
  std::unique_ptr<UsbtmcDevice> device(new UsbtmcDevice(std::move(usb).value()));
  const auto capabilities = usbtmc::DecodeCapabilities(*reply);
  if (!capabilities) return device->About(capabilities.error());
  device->capabilities_ = *capabilities;
  return device;
}

Result<void> UsbtmcDevice::Write(std::string_view message, Seconds limit) {
  const std::lock_guard lock(mutex_);
  const Deadline deadline(limit);
  if (stuck_) {
    if (const auto cleared = ClearAll(Deadline(kRecoveryLimit)); !cleared) return cleared.error();
  }
  do {
    const std::string_view part = message.substr(0, kTransferBytes);
    message.remove_prefix(part.size());
    const auto sent =
        usb_->Write(usbtmc::EncodeOut(NewTag(), part, message.empty()), deadline.Left());
    if (!sent) return AfterFailedWrite(InAll(sent.error(), "not all bytes were taken", deadline));
  } while (!message.empty());
  return {};
}

Result<std::string> UsbtmcDevice::Read(Seconds limit) {
  const std::lock_guard lock(mutex_);
  return ReadParts(Deadline(limit));
}

Result<std::string> UsbtmcDevice::ReadParts(const Deadline& deadline) {
  std::string message;
  while (true) {
    const auto asked =
        usb_->Write(usbtmc::EncodeRequestIn(NewTag(), kTransferBytes), deadline.Left());
    const char* const missing = message.empty() ? "no answer" : "no end of the answer";
    // Neither what was asked nor what was answered so far is known then.
    if (!asked) return AfterNonsense(InAll(asked.error(), missing, deadline));
    const auto part = ReadPart(deadline);
    if (!part && message.empty()) return AfterFailedRead(InAll(part.error(), missing, deadline));
    // An abort ends a transfer; the rest of the message would come with the next one.
    if (!part) return AfterNonsense(InAll(part.error(), missing, deadline));
    message += part->payload;
    if (part->last && message.size() <= kMostBytes) return message;
    if (message.size() > kMostBytes) {
      return AfterFailedRead({ErrorCode::kProtocol, fmt::format("{}: {} bytes and no end of the "
                                                                "answer",
                                                                name(), kMostBytes)});
    }
  }
}

// The answer to one request, which may come in several pieces.
Result<UsbtmcDevice::Part> UsbtmcDevice::ReadPart(const Deadline& deadline) {
  // Room for padding, and for the packet that is not full by which the device ends.
  const std::size_t packet = usb_->packet_bytes();
  const std::size_t room =
      (usbtmc::kHeaderBytes + kTransferBytes + packet - 1) / packet * packet + packet;
  auto bytes = usb_->Read(room, deadline.Left());
  // Some devices begin with a transfer of nothing.
  if (bytes && bytes->empty()) bytes = usb_->Read(room, deadline.Left());
  if (!bytes) return bytes.error();
  const auto header = usbtmc::DecodeIn(*bytes, tag_, kTransferBytes);
  if (!header) return About(header.error());
  Part part{.payload = bytes->substr(usbtmc::kHeaderBytes), .last = header->end_of_message};
  while (part.payload.size() < header->bytes) {
    const auto more = usb_->Read(room, deadline.Left());
    if (!more) return more.error();
    if (more->empty()) {
      return Error{ErrorCode::kProtocol, fmt::format("{}: {} of {} bytes came", name(),
                                                     part.payload.size(), header->bytes)};
    }
    part.payload += *more;
  }
  part.payload.resize(header->bytes);
  return part;
}

Result<void> UsbtmcDevice::Clear() {
  const std::lock_guard lock(mutex_);
  return ClearAll(Deadline(kRecoveryLimit));
}

Result<usbtmc::StatusReply> UsbtmcDevice::Ask(Request request, UsbInterface::About about,
                                              std::uint16_t value, const Deadline& deadline) {
  const bool short_reply = request == Request::kInitiateAbortBulkIn ||
                           request == Request::kInitiateAbortBulkOut ||
                           request == Request::kCheckClearStatus;
  const std::uint16_t most = request == Request::kInitiateClear ? 1 : short_reply ? 2 : 8;
  const auto reply = usb_->Ask(static_cast<std::uint8_t>(request), value, about, most,
                               std::min(kRequestLimit, deadline.Left()));
  if (!reply) return reply.error();
  auto status = usbtmc::DecodeStatus(request, *reply);
  if (!status) return About(status.error());
  return status;
}

Result<void> UsbtmcDevice::AwaitEnd(Request check, UsbInterface::About about,
                                    const Deadline& deadline) {
  while (true) {
    const auto status = Ask(check, about, 0, deadline);
    if (!status) return status.error();
    if (status->status == Status::kSuccess) return {};
    if (status->status != Status::kPending) {
      return Error{ErrorCode::kProtocol,
                   fmt::format("{}: {}", name(), usbtmc::TextOf(status->status))};
    }
    if (deadline.Left() <= Seconds(0)) {
      return Error{ErrorCode::kTimeout, fmt::format("{}: still busy", name())};
    }
    if (status->more_to_read) {
      if (const auto read = ReadAway(deadline); !read) return read;
    } else {
      std::this_thread::sleep_for(kPollInterval);
    }
  }
}

// Until a packet that is not full.
Result<void> UsbtmcDevice::ReadAway(const Deadline& deadline) {
  const std::size_t room = (kTransferBytes / usb_->packet_bytes() + 2) * usb_->packet_bytes();
  for (int i = 0; i < kMostReadAway && deadline.Left() > Seconds(0); ++i) {
    const auto bytes = usb_->Read(room, std::min(kReadAwayLimit, deadline.Left()));
    if (!bytes && bytes.error().code == ErrorCode::kTimeout) return {};
    if (!bytes) return bytes.error();
    if (bytes->size() < room) return {};
  }
  return {};
}

Error UsbtmcDevice::AfterFailedWrite(const Error& error) {
  if (error.code == ErrorCode::kDisconnected) return error;
  const Deadline deadline(kRecoveryLimit);
  auto recovery = AbortOut(deadline);
  if (!recovery) recovery = ClearAll(deadline);
  return Outcome(error, recovery);
}

Result<void> UsbtmcDevice::AbortOut(const Deadline& deadline) {
  constexpr auto kOut = UsbInterface::About::kOut;
  const auto status = Ask(Request::kInitiateAbortBulkOut, kOut, tag_, deadline);
  if (!status) return status.error();
  if (status->status == Status::kSuccess) {
    const auto ended = AwaitEnd(Request::kCheckAbortBulkOutStatus, kOut, deadline);
    if (!ended) return ended;
  } else if (status->status != Status::kFailed) {
    return Error{ErrorCode::kProtocol, usbtmc::TextOf(status->status)};
  }
  return usb_->ClearHalt(kOut);
}

Error UsbtmcDevice::AfterFailedRead(const Error& error) {
  if (error.code != ErrorCode::kTimeout) return AfterNonsense(error);
  const Deadline deadline(kRecoveryLimit);
  auto recovery = AbortIn(deadline);
  if (!recovery) recovery = ClearAll(deadline);
  return Outcome(error, recovery);
}

Error UsbtmcDevice::AfterNonsense(const Error& error) {
  if (error.code == ErrorCode::kDisconnected) return error;
  return Outcome(error, ClearAll(Deadline(kRecoveryLimit)));
}

Result<void> UsbtmcDevice::AbortIn(const Deadline& deadline) {
  constexpr auto kIn = UsbInterface::About::kIn;
  const auto status = Ask(Request::kInitiateAbortBulkIn, kIn, tag_, deadline);
  if (!status) return status.error();
  if (status->status == Status::kFailed) return {};  // nothing in progress and nothing left
  if (status->status != Status::kSuccess) {
    return Error{ErrorCode::kProtocol, usbtmc::TextOf(status->status)};
  }
  if (const auto read = ReadAway(deadline); !read) return read;
  return AwaitEnd(Request::kCheckAbortBulkInStatus, kIn, deadline);
}

Result<void> UsbtmcDevice::ClearAll(const Deadline& deadline) {
  stuck_ = true;
  constexpr auto kInterface = UsbInterface::About::kInterface;
  if (const auto free = usb_->ClearHalt(UsbInterface::About::kIn); !free) return free;
  const auto status = Ask(Request::kInitiateClear, kInterface, 0, deadline);
  if (!status) return status.error();
  if (status->status != Status::kSuccess) {
    return Error{ErrorCode::kProtocol, fmt::format("{}: it does not let itself be cleared: {}",
                                                   name(), usbtmc::TextOf(status->status))};
  }
  const auto ended = AwaitEnd(Request::kCheckClearStatus, kInterface, deadline);
  if (!ended) return ended;
  if (const auto free = usb_->ClearHalt(UsbInterface::About::kOut); !free) return free;
  stuck_ = false;
  return {};
}

Error UsbtmcDevice::Outcome(const Error& error, const Result<void>& recovery) {
  if (recovery) return error;
  if (recovery.error().code == ErrorCode::kDisconnected) return recovery.error();
  stuck_ = true;
  return {error.code, fmt::format("{}, and it could not be cleared: {}", error.message,
                                  recovery.error().message)};
}

Error UsbtmcDevice::InAll(const Error& error, const char* missing, const Deadline& deadline) const {
  if (error.code != ErrorCode::kTimeout) return error;
  return {error.code,
          fmt::format("{}: {} within {:.3g} s", name(), missing, deadline.limit().count())};
}

Error UsbtmcDevice::About(const Error& error) const {
  return {error.code, fmt::format("{}: {}", name(), error.message)};
}

}  // namespace gonio
