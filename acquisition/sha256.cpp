// SPDX-License-Identifier: Apache-2.0
#include "acquisition/sha256.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>

#include "core/file.h"

namespace gonio {
namespace {

constexpr int kRounds = 64;
constexpr int kWords = 8;
constexpr std::size_t kBlockBytes = 64;

// The first 32 bits of the fractional part of `root`, as FIPS 180-4 defines its constants. Exact:
// a long double holds the 4 integer and 32 fractional bits needed with room to spare.
std::uint32_t FractionalBits(long double root) {
  return static_cast<std::uint32_t>((root - std::floor(root)) * 4294967296.0L);
}

struct Constants {
  std::array<std::uint32_t, kRounds> round;   // from the cube roots of the first 64 primes
  std::array<std::uint32_t, kWords> initial;  // from the square roots of the first 8
};

Constants MakeConstants() {
  Constants constants{};
  int found = 0;
  for (int n = 2; found < kRounds; ++n) {
    bool prime = true;
    for (int d = 2; d * d <= n; ++d) prime = prime && n % d != 0;
    if (!prime) continue;
    constants.round[found] = FractionalBits(std::cbrt(static_cast<long double>(n)));
    if (found < kWords)
      constants.initial[found] = FractionalBits(std::sqrt(static_cast<long double>(n)));
    ++found;
  }
  return constants;
}

std::array<std::uint32_t, kRounds> Schedule(const unsigned char* block) {
  std::array<std::uint32_t, kRounds> w{};
  for (int t = 0; t < 16; ++t) {
    for (int byte = 0; byte < 4; ++byte) w[t] = w[t] << 8 | block[4 * t + byte];
  }
  for (int t = 16; t < kRounds; ++t) {
    const auto s0 = std::rotr(w[t - 15], 7) ^ std::rotr(w[t - 15], 18) ^ w[t - 15] >> 3;
    const auto s1 = std::rotr(w[t - 2], 17) ^ std::rotr(w[t - 2], 19) ^ w[t - 2] >> 10;
    w[t] = w[t - 16] + s0 + w[t - 7] + s1;
  }
  return w;
}

void Compress(const Constants& constants, const unsigned char* block,
              std::array<std::uint32_t, kWords>& state) {
  const auto w = Schedule(block);
  auto [a, b, c, d, e, f, g, h] = state;
  for (int t = 0; t < kRounds; ++t) {
    const auto sum1 = std::rotr(e, 6) ^ std::rotr(e, 11) ^ std::rotr(e, 25);
    const auto t1 = h + sum1 + ((e & f) ^ (~e & g)) + constants.round[t] + w[t];
    const auto sum0 = std::rotr(a, 2) ^ std::rotr(a, 13) ^ std::rotr(a, 22);
    const auto t2 = sum0 + ((a & b) ^ (a & c) ^ (b & c));
    h = g, g = f, f = e, e = d + t1, d = c, c = b, b = a, a = t1 + t2;
  }
  const std::array<std::uint32_t, kWords> sum{a, b, c, d, e, f, g, h};
  for (int i = 0; i < kWords; ++i) state[i] += sum[i];
}

}  // namespace

std::string Sha256(std::string_view bytes) {
  static const Constants constants = MakeConstants();
  auto state = constants.initial;
  const auto* begin = reinterpret_cast<const unsigned char*>(bytes.data());
  const std::size_t whole = bytes.size() / kBlockBytes * kBlockBytes;
  for (std::size_t i = 0; i < whole; i += kBlockBytes) Compress(constants, begin + i, state);

  // The rest, a one bit, zeros, and the length in bits as a 64-bit big-endian number.
  std::array<unsigned char, 2 * kBlockBytes> tail{};
  const std::size_t rest = bytes.size() - whole;
  std::copy_n(begin + whole, rest, tail.begin());
  tail[rest] = 0x80;
  const std::size_t end = rest + 9 <= kBlockBytes ? kBlockBytes : 2 * kBlockBytes;
  const std::uint64_t bits = std::uint64_t{bytes.size()} * 8;
  for (int i = 0; i < 8; ++i) tail[end - 1 - i] = static_cast<unsigned char>(bits >> (8 * i));
  for (std::size_t i = 0; i < end; i += kBlockBytes) Compress(constants, tail.data() + i, state);

  std::string hex;
  for (const std::uint32_t word : state) hex += fmt::format("{:08x}", word);
  return hex;
}

std::string Sha256OfFile(const std::filesystem::path& path) { return Sha256(ReadTextFile(path)); }

}  // namespace gonio
