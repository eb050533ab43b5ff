// SPDX-License-Identifier: Apache-2.0
// Lines of a Zaber chain: decoded, and commands whose data is what came.
#include "core/check.h"
#include "drivers/zaber_codec.h"
#include "tests/fuzz/scripted_link.h"

namespace gonio::zaber {
namespace {

void Check(const Message& message) {
  GONIO_CHECK(message.device >= 0 && message.device <= 99, "a device has a number");
  GONIO_CHECK(message.axis >= 0 && message.axis <= 9, "an axis has a number");
  GONIO_CHECK(!message.id || (*message.id >= 0 && *message.id <= 255), "an id is a byte");
  GONIO_CHECK(message.warning.empty() || message.warning.size() == 2, "flags have two letters");
  GONIO_CHECK(message.kind != Kind::kAlert || !message.id, "alerts answer nothing");
}

// What a command says reads back from an info message of the same words.
void CheckRoundTrip(const Message& message) {
  const bool plain = message.data.find_first_of("/@#!:\\\r\n") == std::string::npos &&
                     std::all_of(message.data.begin(), message.data.end(),
                                 [](char c) { return static_cast<unsigned char>(c) < 0x80; });
  if (!plain || message.data.size() > 60) return;
  std::string line =
      Encode({.device = message.device, .axis = message.axis, .id = 7, .data = message.data});
  GONIO_CHECK(line.size() <= kMostBytes && line.back() == '\n', "a command is a packet");
  line.front() = '#';
  line.pop_back();
  const Result<Message> same = Decode(line);
  GONIO_CHECK(same.ok(), "what was encoded can be decoded");
  GONIO_CHECK(same->device == message.device && same->axis == message.axis && same->id == 7 &&
                  same->data == message.data,
              "it is the same");
}

}  // namespace
}  // namespace gonio::zaber

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const auto message = gonio::zaber::Decode(gonio::TextOf(data, size));
  if (!message) return 0;
  gonio::zaber::Check(*message);
  gonio::zaber::CheckRoundTrip(*message);
  return 0;
}
