// SPDX-License-Identifier: Apache-2.0
#include "sim/usbtmc_emulator.h"

#include <algorithm>
#include <initializer_list>
#include <utility>

namespace gonio {
namespace {

// Class requests and their answers.
constexpr int kInitiateAbortOut = 1;
constexpr int kCheckAbortOut = 2;
constexpr int kInitiateAbortIn = 3;
constexpr int kCheckAbortIn = 4;
constexpr int kInitiateClear = 5;
constexpr int kCheckClear = 6;
constexpr int kGetCapabilities = 7;
constexpr int kSuccess = 0x01;
constexpr int kPending = 0x02;
constexpr int kFailed = 0x80;
constexpr int kNotInProgress = 0x81;

constexpr std::uint8_t kToInterface = 0xa1;
constexpr std::uint8_t kToEndpoint = 0xa2;
constexpr int kInterface = 1;
constexpr std::uint8_t kOutEndpoint = 0x02;
constexpr std::uint8_t kInEndpoint = 0x83;
constexpr int kPacket = 64;  // of a full-speed device

constexpr std::size_t kHeader = 12;
constexpr std::size_t kMostMessage = 1 << 16;  // bytes that it can hold

std::string Bytes(std::initializer_list<int> bytes) {
  std::string text;
  for (const int byte : bytes) text += static_cast<char>(byte);
  return text;
}

unsigned At(std::string_view bytes, std::size_t index) {
  return static_cast<unsigned char>(bytes[index]);
}

std::size_t SizeIn(std::string_view header) {
  return At(header, 4) | At(header, 5) << 8 | At(header, 6) << 16 | At(header, 7) << 24;
}

std::size_t Padded(std::size_t size) { return (size + 3) & ~std::size_t{3}; }

void AddWord(std::string* bytes, unsigned word) {
  *bytes += static_cast<char>(word & 0xff);
  *bytes += static_cast<char>(word >> 8 & 0xff);
}

UsbOutcome Done(std::string bytes = {}) { return {UsbOutcome::Kind::kDone, std::move(bytes)}; }
UsbOutcome Stalled() { return {UsbOutcome::Kind::kStalled, {}}; }
UsbOutcome Later() { return {UsbOutcome::Kind::kLater, {}}; }

}  // namespace

UsbtmcEmulator::UsbtmcEmulator(UsbPlate plate, Instrument instrument)
    : plate_(std::move(plate)), instrument_(std::move(instrument)) {}

void UsbtmcEmulator::Inject(UsbtmcFault fault, int times) {
  const std::lock_guard lock(mutex_);
  fault_ = fault;
  fault_times_ = times;
}

void UsbtmcEmulator::set_refuses_aborts(bool refuses) {
  const std::lock_guard lock(mutex_);
  refuses_aborts_ = refuses;
}

int UsbtmcEmulator::clears() const {
  const std::lock_guard lock(mutex_);
  return clears_;
}

int UsbtmcEmulator::aborts() const {
  const std::lock_guard lock(mutex_);
  return aborts_;
}

std::size_t UsbtmcEmulator::longest() const {
  const std::lock_guard lock(mutex_);
  return longest_;
}

bool UsbtmcEmulator::Takes(UsbtmcFault fault) {
  if (fault_ != fault || fault_times_ == 0) return false;
  --fault_times_;
  return true;
}

std::string UsbtmcEmulator::Descriptors() const {
  std::string device = Bytes({18, 1, 0x00, 0x02, 0, 0, 0, kPacket});
  AddWord(&device, static_cast<unsigned>(plate_.vendor));
  AddWord(&device, static_cast<unsigned>(plate_.product));
  device += Bytes({0x00, 0x01, 1, 2, 3, 1});  // numbers of the texts: maker, description, serial
  // For new firmware (class 0xfe, subclass 1): no endpoints.
  const std::string firmware = Bytes({9, 4, 0, 0, 0, 0xfe, 1, 1, 0});
  const std::string instrument = Bytes({9, 4, kInterface, 0, 3, 0xfe, 3, 1, 0});
  const auto endpoint = [](int address, int type, int packet, int interval) {
    return Bytes({7, 5, address, type, packet, 0, interval});
  };
  const std::string interfaces = firmware + instrument + endpoint(kOutEndpoint, 2, kPacket, 0) +
                                 endpoint(kInEndpoint, 2, kPacket, 0) + endpoint(0x81, 3, 8, 16);
  std::string configuration = Bytes({9, 2});
  AddWord(&configuration, static_cast<unsigned>(9 + interfaces.size()));
  configuration += Bytes({2, 1, 0, 0xc0, 50});
  return device + configuration + interfaces;
}

UsbOutcome UsbtmcEmulator::Control(const UsbSetup& setup) {
  const std::lock_guard lock(mutex_);
  const bool of_endpoint = setup.request >= kInitiateAbortOut && setup.request <= kCheckAbortIn;
  if (setup.type != (of_endpoint ? kToEndpoint : kToInterface)) return Stalled();
  const bool of_out = setup.request == kInitiateAbortOut || setup.request == kCheckAbortOut;
  const int index = of_endpoint ? (of_out ? kOutEndpoint : kInEndpoint) : kInterface;
  if (setup.index != index) return Stalled();
  std::string reply;
  switch (setup.request) {
    case kInitiateAbortOut:
      ++aborts_;
      reply = Bytes({coming_.empty() ? kFailed : kSuccess, setup.value});
      coming_.clear();
      message_.clear();
      break;
    case kCheckAbortOut:
      reply = Bytes({kSuccess, 0, 0, 0, 0, 0, 0, 0});
      break;
    case kInitiateAbortIn:
      reply = AbortIn(static_cast<std::uint8_t>(setup.value));
      break;
    case kCheckAbortIn:
      reply =
          Bytes({transfers_.empty() ? kSuccess : kPending, !transfers_.empty(), 0, 0, 0, 0, 0, 0});
      break;
    case kInitiateClear:
      ++clears_;
      Forget();
      out_halted_ = true;  // until the host clears that, too
      reply = Bytes({kSuccess});
      break;
    case kCheckClear:
      reply = Bytes({kSuccess, 0});
      break;
    case kGetCapabilities:
      reply.assign(24, '\0');
      reply[0] = kSuccess;
      reply[3] = 1;   // USBTMC 1.00
      reply[13] = 1;  // USB488 1.00
      reply[14] = 4;  // IEEE 488.2
      reply[15] = 8;  // SCPI
      break;
    default:
      return Stalled();
  }
  return Done(reply.substr(0, setup.length));
}

// The host gives up the transfer of this tag.
std::string UsbtmcEmulator::AbortIn(std::uint8_t tag) {
  ++aborts_;
  const auto reply = [tag](int status) { return Bytes({status, tag}); };
  if (refuses_aborts_) return reply(kNotInProgress);
  const bool in_progress = request_.has_value() || !transfers_.empty();
  if (!in_progress) return reply(answers_.empty() ? kFailed : kNotInProgress);
  if (request_ && request_->tag != tag) return reply(kNotInProgress);
  request_.reset();
  // Even if nothing was sent yet, the end of the transfer is.
  if (transfers_.empty()) transfers_.emplace_back();
  return reply(kSuccess);
}

UsbOutcome UsbtmcEmulator::Out(std::string_view bytes) {
  const std::lock_guard lock(mutex_);
  if (out_halted_ || Takes(UsbtmcFault::kStallOut)) {
    out_halted_ = true;
    return Stalled();
  }
  coming_ += bytes;
  while (coming_.size() >= kHeader) {
    if (!TakeTransfer()) break;
  }
  return out_halted_ ? Stalled() : Done();
}

// Whether there was a whole one. Nonsense halts the pipe.
bool UsbtmcEmulator::TakeTransfer() {
  const unsigned kind = At(coming_, 0);
  const unsigned tag = At(coming_, 1);
  const std::size_t size = SizeIn(coming_);
  const bool sense = tag != 0 && tag + At(coming_, 2) == 0xff && At(coming_, 3) == 0 &&
                     ((kind == 1 && size > 0) || (kind == 2 && size > 0));
  if (!sense || message_.size() + (kind == 1 ? size : 0) > kMostMessage) {
    coming_.clear();
    message_.clear();
    out_halted_ = true;
    return false;
  }
  if (kind == 2) {
    request_ = Request{static_cast<std::uint8_t>(tag), size};
    coming_.erase(0, kHeader);
    AnswerRequest();
    return true;
  }
  if (coming_.size() < kHeader + Padded(size)) return false;
  message_ += coming_.substr(kHeader, size);
  const bool end = (At(coming_, 8) & 1) != 0;
  coming_.erase(0, kHeader + Padded(size));
  if (end) TakeMessage(std::exchange(message_, {}));
  return true;
}

void UsbtmcEmulator::TakeMessage(const std::string& message) {
  longest_ = std::max(longest_, message.size());
  if (!late_.empty()) answers_.push_back(std::exchange(late_, {}));
  std::string answer = instrument_(message.substr(0, message.find_last_not_of("\r\n") + 1));
  if (answer.empty() || Takes(UsbtmcFault::kSilent)) return;
  answer += '\n';
  if (Takes(UsbtmcFault::kLate)) {
    late_ = std::move(answer);
  } else {
    answers_.push_back(std::move(answer));
  }
}

void UsbtmcEmulator::AnswerRequest() {
  if (!request_ || answers_.empty()) return;
  if (Takes(UsbtmcFault::kStallIn)) {
    answers_.clear();
    request_.reset();
    in_halted_ = true;
    return;
  }
  std::string& answer = answers_.front();
  const bool again = Takes(UsbtmcFault::kNeverEnds);
  const std::size_t most = again || Takes(UsbtmcFault::kNoEnd)
                               ? std::max<std::size_t>(answer.size() / 2, 1)
                               : request_->most;
  const std::string payload = answer.substr(0, most);
  if (!again) answer.erase(0, payload.size());
  const bool end = answer.empty();
  if (end) answers_.pop_front();
  SendTransfer(payload, end);
  request_.reset();
}

void UsbtmcEmulator::SendTransfer(const std::string& payload, bool end) {
  const int tag = request_->tag ^ (Takes(UsbtmcFault::kWrongTag) ? 0x55 : 0);
  std::size_t size = payload.size();
  if (Takes(UsbtmcFault::kOversize)) size = 0xffffffff;
  if (Takes(UsbtmcFault::kShort)) size += 100;
  std::string transfer = Bytes({2, tag, 0xff - tag, 0});
  AddWord(&transfer, static_cast<unsigned>(size & 0xffff));
  AddWord(&transfer, static_cast<unsigned>(size >> 16));
  transfer += Bytes({end ? 1 : 0, 0, 0, 0});
  if (Takes(UsbtmcFault::kEmptyFirst)) transfers_.emplace_back();
  if (Takes(UsbtmcFault::kHeaderFirst)) transfers_.push_back(std::exchange(transfer, {}));
  transfer += payload;
  transfer.resize(Padded(transfer.size()), '\0');
  transfers_.push_back(std::move(transfer));
}

UsbOutcome UsbtmcEmulator::In(std::size_t most) {
  const std::lock_guard lock(mutex_);
  if (in_halted_) return Stalled();
  if (transfers_.empty()) AnswerRequest();
  if (in_halted_) return Stalled();
  if (transfers_.empty()) return Later();
  std::string& transfer = transfers_.front();
  std::string bytes = transfer.substr(0, most);
  transfer.erase(0, bytes.size());
  // A transfer of whole packets ends with an empty one, unless the host reads no further.
  const bool ended = bytes.size() < most || bytes.size() % kPacket != 0;
  if (ended) transfers_.pop_front();
  return Done(std::move(bytes));
}

void UsbtmcEmulator::ClearHalt(std::uint8_t endpoint) {
  const std::lock_guard lock(mutex_);
  if (endpoint == kInEndpoint) in_halted_ = false;
  if (endpoint == kOutEndpoint) out_halted_ = false;
}

void UsbtmcEmulator::Forget() {
  coming_.clear();
  message_.clear();
  answers_.clear();
  transfers_.clear();
  request_.reset();
}

void UsbtmcEmulator::Reset() {
  const std::lock_guard lock(mutex_);
  Forget();
  late_.clear();
  in_halted_ = out_halted_ = false;
}

}  // namespace gonio
