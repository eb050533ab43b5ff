// SPDX-License-Identifier: Apache-2.0
// A link whose far end says what a fuzzer thought of, whatever it is told.

#pragma once

#include <algorithm>
#include <cstdint>
#include <string>
#include <utility>

#include "drivers/byte_link.h"

namespace gonio {

// Each piece is a byte with its length and the piece; one of length 0 is a time-out, and of length
// 255 five thousand times the one byte that follows (once per script: it takes long). After the
// last one the link is gone. Waits for nothing.
class ScriptedLink final : public ByteLink {
 public:
  explicit ScriptedLink(std::string script) : script_(std::move(script)) {}

  const std::string& name() const override { return name_; }
  Result<void> Write(std::string_view, Seconds) override {
    return at_ < script_.size() ? Result<void>() : Gone();
  }
  Result<std::string> Read(std::size_t most, Seconds) override {
    if (piece_.empty()) {
      if (at_ >= script_.size()) return Gone();
      const std::size_t length = static_cast<unsigned char>(script_[at_++]);
      const bool endless = length == 255 && at_ < script_.size() && !std::exchange(flooded_, true);
      piece_ = endless ? std::string(5000, script_[at_]) : script_.substr(at_, length);
      at_ += endless ? 1 : piece_.size();
      if (piece_.empty()) return Error{ErrorCode::kTimeout, name_ + ": no answer"};
    }
    std::string bytes = piece_.substr(0, most);
    piece_.erase(0, bytes.size());
    said_ += bytes;
    return bytes;
  }
  Result<void> DiscardInput() override {
    piece_.clear();
    return {};
  }

  // All that was read so far.
  const std::string& said() const { return said_; }

 private:
  Error Gone() const { return {ErrorCode::kDisconnected, name_ + ": disconnected"}; }

  std::string name_ = "script";
  std::string script_;
  std::string piece_;
  std::string said_;
  std::size_t at_ = 0;
  bool flooded_ = false;
};

// The bytes of a fuzzer as text.
inline std::string TextOf(const std::uint8_t* data, std::size_t size) {
  return size == 0 ? std::string() : std::string(reinterpret_cast<const char*>(data), size);
}

}  // namespace gonio
