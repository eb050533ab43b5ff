// SPDX-License-Identifier: Apache-2.0
// Transfers and answers of USB test and measurement instruments.
#include "core/check.h"
#include "drivers/usbtmc_codec.h"
#include "tests/fuzz/scripted_link.h"

namespace gonio::usbtmc {
namespace {

constexpr std::size_t kMost = 1024;

void CheckTransfer(const std::string& bytes) {
  const auto tag = static_cast<std::uint8_t>(bytes.size() > 1 ? bytes[1] : 1);
  const Result<InHeader> header = DecodeIn(bytes, tag, kMost);
  if (!header) return;
  GONIO_CHECK(bytes.size() >= kHeaderBytes, "a header is whole");
  GONIO_CHECK(header->bytes <= kMost, "no more than was asked for");
  GONIO_CHECK(!DecodeIn(bytes, NextTag(tag), kMost), "it answers one request only");
}

void CheckReplies(const std::string& bytes) {
  (void)DecodeCapabilities(bytes).ok();
  for (int request = 1; request <= 6; ++request) {
    const auto status = DecodeStatus(static_cast<Request>(request), bytes);
    GONIO_CHECK(!status || !bytes.empty(), "nothing is no status");
    if (status) GONIO_CHECK(*TextOf(status->status) != '\0', "a status has words");
  }
}

// What goes out comes back in, if the device says what it heard.
void CheckOut(const std::string& payload) {
  if (payload.size() > kMost) return;
  std::string transfer = EncodeOut(7, payload, true);
  GONIO_CHECK(transfer.size() % 4 == 0, "transfers are padded");
  transfer[0] = 2;  // as an answer
  const auto header = DecodeIn(transfer, 7, kMost);
  GONIO_CHECK(header.ok() || payload.empty(), "it is understood");
  if (header) GONIO_CHECK(header->bytes == payload.size() && header->end_of_message, "unchanged");
}

}  // namespace
}  // namespace gonio::usbtmc

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string bytes = gonio::TextOf(data, size);
  gonio::usbtmc::CheckTransfer(bytes);
  gonio::usbtmc::CheckReplies(bytes);
  gonio::usbtmc::CheckOut(bytes);
  return 0;
}
