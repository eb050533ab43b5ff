// SPDX-License-Identifier: Apache-2.0
// Numbers as GigE Vision sends them: most significant byte first.

#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace gonio {

using Bytes = std::vector<std::uint8_t>;

// Appends the last `size` bytes of `value`.
inline void PutBigEndian(Bytes& bytes, std::uint64_t value, int size) {
  for (int i = size - 1; i >= 0; --i) bytes.push_back(static_cast<std::uint8_t>(value >> 8 * i));
}

// Reads `size` bytes from `at`, which must be there.
inline std::uint32_t GetBigEndian(std::span<const std::uint8_t> bytes, std::size_t at, int size) {
  std::uint32_t value = 0;
  for (int i = 0; i < size; ++i) value = value << 8 | bytes[at + i];
  return value;
}

}  // namespace gonio
