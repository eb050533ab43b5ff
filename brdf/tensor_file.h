// SPDX-License-Identifier: Apache-2.0
// The container of RGL's `.bsdf` files: named arrays of numbers.

#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <vector>

namespace gonio {

// A "tensor_file" of version 1.0, read whole into memory. Little-endian: magic "tensor_file" with a
// zero, version (2 bytes), uint32 number of fields, then per field: uint16 length and name, uint16
// number of dimensions, uint8 type, uint64 offset of the numbers from the file's begin, uint64 for
// each dimension.
class TensorFile {
 public:
  // Throws ConfigError "FILE: what is wrong": unreadable, no such file, another version, truncated.
  static TensorFile Open(const std::filesystem::path& path);

  bool Has(const std::string& name) const { return fields_.contains(name); }
  // Throws ConfigError "FILE: field NAME ..." if there is no such field.
  const std::vector<std::size_t>& Shape(const std::string& name) const;

  // The numbers of a field that must have this type (and, unless empty, this shape), the last
  // dimension running fastest. Throws ConfigError "FILE: field NAME ..." if it is missing or other,
  // or holds a number that is not finite.
  std::vector<float> Floats(const std::string& name,
                            const std::vector<std::size_t>& shape = {}) const;
  std::vector<std::uint8_t> Bytes(const std::string& name,
                                  const std::vector<std::size_t>& shape = {}) const;

  const std::filesystem::path& path() const { return path_; }
  [[noreturn]] void Fail(const std::string& complaint) const;

 private:
  struct Field {
    std::uint8_t type = 0;
    std::size_t offset = 0;
    std::vector<std::size_t> shape;
    std::size_t count = 0;  // product of the shape
  };

  const Field& Find(const std::string& name, std::uint8_t type,
                    const std::vector<std::size_t>& shape) const;

  std::filesystem::path path_;
  std::string content_;
  std::map<std::string, Field> fields_;
};

}  // namespace gonio
