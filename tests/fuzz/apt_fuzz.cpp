// SPDX-License-Identifier: Apache-2.0
// What a controller may say, whatever it is.
#include <cstddef>
#include <cstdint>
#include <string>

#include "core/check.h"
#include "drivers/apt_codec.h"

namespace gonio::apt {
namespace {

// What is read can be written again, and is the same.
void CheckDecoders(const Message& message) {
  if (const auto velocity = DecodeVelocity(message)) {
    GONIO_CHECK(SetVelocity(kUsbUnit, *velocity).data == message.data, "velocity");
  }
  if (const auto backlash = DecodeBacklash(message)) {
    GONIO_CHECK(SetBacklash(kUsbUnit, *backlash).data == message.data, "backlash");
  }
  if (const auto status = DecodeStatus(message)) {
    GONIO_CHECK(ChannelOf(message) == status->channel, "channel");
    (void)FaultsIn(status->bits);
  }
  if (const auto info = DecodeInfo(message)) {
    GONIO_CHECK(info->model.find('\n') == std::string::npos, "an identity is one line");
  }
  (void)DecodeHoming(message);
  if (const auto report = ReportIn(message)) {
    GONIO_CHECK(report->text.find('\n') == std::string::npos, "a message of an error is one line");
  }
  GONIO_CHECK(!NameOf(message.id).empty(), "every message has a name");
}

void CheckAll(std::string bytes) {
  while (true) {
    const std::string before = bytes;
    const auto message = TakeMessage(&bytes);
    if (!message || !*message) {
      GONIO_CHECK(bytes == before, "what cannot be taken stays");
      return;
    }
    GONIO_CHECK((*message)->dest == kHost, "for the host");
    GONIO_CHECK(Encode(**message) + bytes == before, "taken and written is the same");
    CheckDecoders(**message);
  }
}

}  // namespace
}  // namespace gonio::apt

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  gonio::apt::CheckAll(std::string(reinterpret_cast<const char*>(data), size));
  return 0;
}
