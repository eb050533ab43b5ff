// SPDX-License-Identifier: Apache-2.0
#include "sim/gige_control.h"

#include <poll.h>
#include <sys/eventfd.h>
#include <unistd.h>

#include <chrono>
#include <optional>
#include <span>
#include <thread>
#include <utility>

#include "sim/gige_memory.h"
#include "sim/udp_socket.h"

namespace gonio {
namespace {

// Commands; an answer's code is one more.
constexpr std::uint16_t kDiscovery = 0x0002;
constexpr std::uint16_t kPacketResend = 0x0040;
constexpr std::uint16_t kReadRegister = 0x0080;
constexpr std::uint16_t kWriteRegister = 0x0082;
constexpr std::uint16_t kReadMemory = 0x0084;
constexpr std::uint16_t kWriteMemory = 0x0086;
constexpr std::uint8_t kCommandKey = 0x42;
constexpr std::uint8_t kAnswerWanted = 0x01;  // of the flags
constexpr std::size_t kHeader = 8;            // bytes of commands and answers
constexpr std::uint16_t kWell = 0x0000;
constexpr std::uint16_t kNotImplemented = 0x8001;
constexpr std::uint16_t kInvalidParameter = 0x8002;
constexpr std::uint16_t kAccessDenied = 0x8006;

// Bootstrap registers.
constexpr std::size_t kDiscoveryBytes = 0xF8;  // from 0, that a search is answered with
constexpr std::uint32_t kHeartbeat = 0x938;    // ms
constexpr std::uint32_t kPrivilege = 0xA00;    // of the client in control; 0: nobody
constexpr int kLookMs = 250;                   // for a heartbeat that has stopped

using Clock = std::chrono::steady_clock;

}  // namespace

class GigeControl::Impl {
 public:
  Impl(const std::string& address, GigeMemory& memory, GigeControlHooks hooks)
      : memory_(memory),
        hooks_(std::move(hooks)),
        socket_(address, kPort),
        searches_("255.255.255.255", kPort),
        wake_(eventfd(0, EFD_CLOEXEC)) {
    if (socket_.ok()) thread_ = std::jthread([this](std::stop_token stop) { Run(stop); });
  }
  ~Impl() {
    thread_ = {};
    close(wake_);
  }

  bool ok() const { return socket_.ok(); }

 private:
  void Run(std::stop_token stop);
  void Handle(const Bytes& command, const UdpPeer& from);
  // What is behind an answer's header; or a status that says why not.
  std::uint16_t Carry(std::uint16_t code, std::span<const std::uint8_t> body, const UdpPeer& from,
                      Bytes& answer);
  std::uint16_t WriteRegisters(std::span<const std::uint8_t> body, const UdpPeer& from,
                               Bytes& answer);
  std::uint16_t ReadBlock(std::span<const std::uint8_t> body, Bytes& answer) const;
  bool MayWrite(std::uint32_t address, const UdpPeer& from) const {
    return controller_ ? *controller_ == from : address == kPrivilege;
  }
  void Release();

  GigeMemory& memory_;
  const GigeControlHooks hooks_;
  const UdpSocket socket_;
  const UdpSocket searches_;  // where that is permitted
  const int wake_;            // ends the wait
  std::optional<UdpPeer> controller_;
  Clock::time_point heard_{};  // the controller, last
  std::jthread thread_;
};

void GigeControl::Impl::Run(std::stop_token stop) {
  const std::stop_callback wake(stop, [this] {
    const std::uint64_t one = 1;
    (void)!write(wake_, &one, sizeof one);
  });
  while (!stop.stop_requested()) {
    pollfd wait[] = {
        {wake_, POLLIN, 0}, {socket_.handle(), POLLIN, 0}, {searches_.handle(), POLLIN, 0}};
    poll(wait, std::size(wait), controller_ ? kLookMs : -1);
    for (const UdpSocket* socket : {&socket_, &searches_}) {
      UdpPeer from;
      while (socket->ok() && !stop.stop_requested()) {
        const auto command = socket->Receive(from);
        if (!command) break;
        Handle(*command, from);
      }
    }
    const std::chrono::milliseconds silence(memory_.Read(kHeartbeat));
    if (controller_ && Clock::now() - heard_ > silence) Release();
  }
}

void GigeControl::Impl::Release() {
  controller_.reset();
  memory_.Write(kPrivilege, 0);
  hooks_.abandoned();
}

void GigeControl::Impl::Handle(const Bytes& command, const UdpPeer& from) {
  if (command.size() < kHeader || command[0] != kCommandKey) return;
  if (controller_ == from) heard_ = Clock::now();
  const auto code = static_cast<std::uint16_t>(GetBigEndian(command, 2, 2));
  Bytes body;
  const std::uint16_t status = Carry(code, std::span(command).subspan(kHeader), from, body);
  if ((command[1] & kAnswerWanted) == 0) return;
  if (status != kWell) body.clear();
  Bytes answer;
  PutBigEndian(answer, status, 2);
  PutBigEndian(answer, code + 1u, 2);
  PutBigEndian(answer, body.size(), 2);
  PutBigEndian(answer, GetBigEndian(command, 6, 2), 2);  // which command it is the answer to
  answer.insert(answer.end(), body.begin(), body.end());
  socket_.Send(from, answer);
}

std::uint16_t GigeControl::Impl::Carry(std::uint16_t code, std::span<const std::uint8_t> body,
                                       const UdpPeer& from, Bytes& answer) {
  switch (code) {
    case kDiscovery:
      answer.resize(kDiscoveryBytes);
      memory_.ReadBytes(0, answer);
      return kWell;
    case kReadRegister:
      for (std::size_t at = 0; at + 4 <= body.size(); at += 4) {
        PutBigEndian(answer, memory_.Read(GetBigEndian(body, at, 4)), 4);
      }
      return kWell;
    case kWriteRegister:
      return WriteRegisters(body, from, answer);
    case kReadMemory:
      return ReadBlock(body, answer);
    case kWriteMemory:
      if (body.size() < 4) return kInvalidParameter;
      if (!MayWrite(GetBigEndian(body, 0, 4), from)) return kAccessDenied;
      memory_.WriteBytes(GetBigEndian(body, 0, 4), body.subspan(4));
      hooks_.written(GetBigEndian(body, 0, 4));
      PutBigEndian(answer, body.size() - 4, 4);
      return kWell;
    case kPacketResend:
      if (body.size() < 12) return kInvalidParameter;
      hooks_.resend(static_cast<std::uint16_t>(GetBigEndian(body, 2, 2)), GetBigEndian(body, 5, 3),
                    GetBigEndian(body, 9, 3));
      return kWell;
    default:
      return kNotImplemented;
  }
}

std::uint16_t GigeControl::Impl::WriteRegisters(std::span<const std::uint8_t> body,
                                                const UdpPeer& from, Bytes& answer) {
  std::uint32_t written = 0;
  for (std::size_t at = 0; at + 8 <= body.size(); at += 8, ++written) {
    const std::uint32_t address = GetBigEndian(body, at, 4);
    const std::uint32_t value = GetBigEndian(body, at + 4, 4);
    if (!MayWrite(address, from)) return kAccessDenied;
    memory_.Write(address, value);
    if (address != kPrivilege) {
      hooks_.written(address);
    } else if (value != 0) {
      controller_ = from;
      heard_ = Clock::now();
    } else if (controller_) {
      Release();
    }
  }
  PutBigEndian(answer, written, 4);
  return kWell;
}

std::uint16_t GigeControl::Impl::ReadBlock(std::span<const std::uint8_t> body,
                                           Bytes& answer) const {
  if (body.size() < 8) return kInvalidParameter;
  const std::uint32_t address = GetBigEndian(body, 0, 4);
  Bytes block(GetBigEndian(body, 6, 2));
  memory_.ReadBytes(address, block);
  PutBigEndian(answer, address, 4);
  answer.insert(answer.end(), block.begin(), block.end());
  return kWell;
}

GigeControl::GigeControl(const std::string& address, GigeMemory& memory, GigeControlHooks hooks)
    : impl_(std::make_unique<Impl>(address, memory, std::move(hooks))) {}
GigeControl::~GigeControl() = default;
bool GigeControl::ok() const { return impl_->ok(); }

}  // namespace gonio
