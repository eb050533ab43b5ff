// SPDX-License-Identifier: Apache-2.0
// Whatever a USB instrument sends, its decoders accept it within their promises or refuse it. Of
// each input the first byte is the tag and the two after it the size that were asked for.
#include <cstddef>
#include <cstdint>
#include <string_view>

#include "core/check.h"
#include "drivers/usbtmc_codec.h"

namespace usbtmc = gonio::usbtmc;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size < 3) return 0;
  const std::uint8_t tag = data[0];
  const std::size_t most = data[1] | std::size_t{data[2]} << 8;
  const std::string_view bytes(reinterpret_cast<const char*>(data) + 3, size - 3);
  if (const auto header = usbtmc::DecodeIn(bytes, tag, most)) {
    GONIO_CHECK(header->bytes <= most, "more than was asked for");
    GONIO_CHECK(bytes.size() >= usbtmc::kHeaderBytes, "a header out of nothing");
  }
  (void)usbtmc::DecodeCapabilities(bytes).ok();
  for (int request = 0; request <= 8; ++request) {
    const auto status = usbtmc::DecodeStatus(static_cast<usbtmc::Request>(request), bytes);
    GONIO_CHECK(!status || usbtmc::TextOf(status->status) != nullptr, "no text");
  }
  // What goes out is four-byte aligned and as long as it says.
  const std::string out = usbtmc::EncodeOut(usbtmc::NextTag(tag), bytes, true);
  GONIO_CHECK(out.size() % 4 == 0 && out.size() >= usbtmc::kHeaderBytes + bytes.size(), "size");
  return 0;
}
