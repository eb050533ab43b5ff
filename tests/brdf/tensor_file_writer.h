// SPDX-License-Identifier: Apache-2.0
// Writes small tensor files (RGL .bsdf), right and wrong ones.

#pragma once

#include <cstdint>
#include <cstring>
#include <string>
#include <vector>

namespace gonio {

class TensorFileWriter {
 public:
  void Add(const std::string& name, const std::vector<std::uint64_t>& shape,
           const std::vector<float>& numbers) {
    fields_.push_back({name, 10, shape, Bytes(numbers)});
  }
  void AddBytes(const std::string& name, const std::vector<std::uint64_t>& shape,
                const std::vector<std::uint8_t>& numbers) {
    fields_.push_back({name, 1, shape, Bytes(numbers)});
  }
  void Remove(const std::string& name) {
    std::erase_if(fields_, [&](const Field& field) { return field.name == name; });
  }

  std::string Content(std::uint8_t major = 1) const {
    std::size_t head = 18;
    for (const Field& f : fields_) head += 2 + f.name.size() + 2 + 1 + 8 + 8 * f.shape.size();
    std::string out("tensor_file\0", 12);
    Put<std::uint8_t>(major, &out);
    Put<std::uint8_t>(0, &out);
    Put<std::uint32_t>(fields_.size(), &out);
    std::uint64_t offset = head;
    std::string numbers;
    for (const Field& f : fields_) {
      Put<std::uint16_t>(f.name.size(), &out);
      out += f.name;
      Put<std::uint16_t>(f.shape.size(), &out);
      Put<std::uint8_t>(f.type, &out);
      Put<std::uint64_t>(offset, &out);
      for (const std::uint64_t size : f.shape) Put<std::uint64_t>(size, &out);
      numbers += f.bytes;
      offset += f.bytes.size();
    }
    return out + numbers;
  }

 private:
  struct Field {
    std::string name;
    std::uint8_t type;
    std::vector<std::uint64_t> shape;
    std::string bytes;
  };
  template <typename T>
  static std::string Bytes(const std::vector<T>& numbers) {
    std::string bytes(numbers.size() * sizeof(T), '\0');
    std::memcpy(bytes.data(), numbers.data(), bytes.size());
    return bytes;
  }
  template <typename T>
  static void Put(std::uint64_t number, std::string* out) {
    const T typed = static_cast<T>(number);
    out->append(reinterpret_cast<const char*>(&typed), sizeof typed);
  }

  std::vector<Field> fields_;
};

}  // namespace gonio
