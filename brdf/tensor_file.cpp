// SPDX-License-Identifier: Apache-2.0
#include "brdf/tensor_file.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <bit>
#include <cmath>
#include <cstring>
#include <string_view>

#include "core/error.h"
#include "core/file.h"

namespace gonio {
namespace {

static_assert(std::endian::native == std::endian::little, "tensor files are little-endian");

constexpr std::string_view kMagic("tensor_file\0", 12);
constexpr std::uint8_t kUint8 = 1;
constexpr std::uint8_t kFloat32 = 10;
// Bytes of a number of each type: none, u1, i1, u2, i2, u4, i4, u8, i8, f2, f4, f8.
constexpr std::size_t kTypeBytes[] = {0, 1, 1, 2, 2, 4, 4, 8, 8, 2, 4, 8};

std::string NameOfType(std::uint8_t type) {
  if (type == kUint8) return "uint8";
  if (type == kFloat32) return "float32";
  return fmt::format("type {}", type);
}

// Reads from the front; whoever asks for more than there is finds out by ok().
class Reader {
 public:
  explicit Reader(std::string_view content) : content_(content) {}

  template <typename T>
  T Number() {
    T number{};
    const std::string_view bytes = Take(sizeof number);
    if (ok_) std::memcpy(&number, bytes.data(), sizeof number);
    return number;
  }
  std::string_view Take(std::size_t count) {
    ok_ = ok_ && count <= content_.size() - at_;
    if (!ok_) return {};
    at_ += count;
    return content_.substr(at_ - count, count);
  }
  bool ok() const { return ok_; }

 private:
  std::string_view content_;
  std::size_t at_ = 0;
  bool ok_ = true;
};

}  // namespace

TensorFile TensorFile::Open(const std::filesystem::path& path) {
  TensorFile file;
  file.path_ = path;
  file.content_ = ReadTextFile(path);
  Reader reader(file.content_);
  if (reader.Take(kMagic.size()) != kMagic) file.Fail("is no tensor file (RGL .bsdf)");
  const int major = reader.Number<std::uint8_t>();
  const int minor = reader.Number<std::uint8_t>();
  const auto count = reader.Number<std::uint32_t>();
  if (reader.ok() && (major != 1 || minor != 0)) {
    file.Fail(fmt::format("is a tensor file of version {}.{}, must be 1.0", major, minor));
  }
  for (std::uint32_t i = 0; i < count && reader.ok(); ++i) {
    const std::string name(reader.Take(reader.Number<std::uint16_t>()));
    Field field;
    const auto dimensions = reader.Number<std::uint16_t>();
    field.type = reader.Number<std::uint8_t>();
    field.offset = reader.Number<std::uint64_t>();
    field.count = 1;
    for (int d = 0; d < dimensions && reader.ok(); ++d) {
      field.shape.push_back(reader.Number<std::uint64_t>());
      // Whatever does not fit into the file is caught below, before it can overflow.
      const bool fits = field.shape.back() <= file.content_.size();
      field.count = fits ? field.count * field.shape.back() : file.content_.size() + 1;
      if (field.count > file.content_.size()) field.count = file.content_.size() + 1;
    }
    if (!reader.ok()) break;
    if (field.type == 0 || field.type >= std::size(kTypeBytes)) {
      file.Fail(fmt::format("field {} has the unknown type {}", name, field.type));
    }
    if (field.offset > file.content_.size() ||
        field.count * kTypeBytes[field.type] > file.content_.size() - field.offset) {
      file.Fail(fmt::format("is truncated: field {} lies beyond its end", name));
    }
    file.fields_[name] = std::move(field);
  }
  if (!reader.ok()) file.Fail("is truncated: its list of fields is not whole");
  return file;
}

const std::vector<std::size_t>& TensorFile::Shape(const std::string& name) const {
  const auto found = fields_.find(name);
  if (found == fields_.end()) Fail(fmt::format("has no field {}", name));
  return found->second.shape;
}

const TensorFile::Field& TensorFile::Find(const std::string& name, std::uint8_t type,
                                          const std::vector<std::size_t>& shape) const {
  Shape(name);
  const Field& field = fields_.at(name);
  if (field.type != type) {
    Fail(fmt::format("field {} has {}, must have {}", name, NameOfType(field.type),
                     NameOfType(type)));
  }
  if (!shape.empty() && field.shape != shape) {
    Fail(fmt::format("field {} has the shape {}, must have {}", name, fmt::join(field.shape, " x "),
                     fmt::join(shape, " x ")));
  }
  return field;
}

std::vector<float> TensorFile::Floats(const std::string& name,
                                      const std::vector<std::size_t>& shape) const {
  const Field& field = Find(name, kFloat32, shape);
  std::vector<float> numbers(field.count);
  std::memcpy(numbers.data(), content_.data() + field.offset, field.count * sizeof(float));
  for (const float number : numbers) {
    if (!std::isfinite(number))
      Fail(fmt::format("field {} holds a number that is not finite", name));
  }
  return numbers;
}

std::vector<std::uint8_t> TensorFile::Bytes(const std::string& name,
                                            const std::vector<std::size_t>& shape) const {
  const Field& field = Find(name, kUint8, shape);
  std::vector<std::uint8_t> bytes(field.count);
  std::memcpy(bytes.data(), content_.data() + field.offset, field.count);
  return bytes;
}

void TensorFile::Fail(const std::string& complaint) const {
  throw ConfigError(path_.string() + ": " + complaint);
}

}  // namespace gonio
