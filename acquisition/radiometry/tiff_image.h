// SPDX-License-Identifier: Apache-2.0
// Images of sites and of counts as TIFF, uncompressed, colours where other programs look for them.

#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

namespace gonio {

struct ImageSize {
  int width = 0;
  int height = 0;
  int per_pixel = 1;  // 1, or 3: red, green, blue, interleaved
};

// The bytes of a file. `path` is for messages. Throws std::runtime_error "PATH: cannot write: ...".
std::string EncodeTiff(const std::filesystem::path& path, const ImageSize& size,
                       std::vector<float> values);
std::string EncodeTiff(const std::filesystem::path& path, const ImageSize& size,
                       std::vector<std::uint16_t> values);

// Throws ConfigError "PATH: ...": no TIFF, or of another size or kind of numbers.
std::vector<float> DecodeTiffFloats(const std::filesystem::path& path, const ImageSize& size,
                                    const std::string& bytes);
std::vector<std::uint16_t> DecodeTiffCounts(const std::filesystem::path& path,
                                            const ImageSize& size, const std::string& bytes);

}  // namespace gonio
