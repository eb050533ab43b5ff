// SPDX-License-Identifier: Apache-2.0
#include "sim/gige_memory.h"

#include <arv.h>
#include <stdlib.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <cstring>
#include <mutex>

#include "core/check.h"

namespace gonio {
namespace {

struct Unref {
  void operator()(void* object) const { g_object_unref(object); }
};

// A text as a file, for as long as it lives: the fake camera reads its description from one.
class TextFile {
 public:
  explicit TextFile(const std::string& text) {
    const int file = mkstemp(path_);
    GONIO_CHECK(file >= 0, "no temporary file");
    FILE* stream = fdopen(file, "w");
    GONIO_CHECK(stream && std::fputs(text.c_str(), stream) >= 0 && std::fclose(stream) == 0,
                "cannot write a temporary file");
  }
  ~TextFile() { unlink(path_); }
  TextFile(const TextFile&) = delete;
  TextFile& operator=(const TextFile&) = delete;
  const char* path() const { return path_; }

 private:
  char path_[sizeof "/tmp/gonio-gige-XXXXXX"] = "/tmp/gonio-gige-XXXXXX";
};

}  // namespace

struct GigeMemory::Impl {
  mutable std::mutex mutex;
  std::unique_ptr<ArvFakeCamera, Unref> camera;
};

GigeMemory::GigeMemory(const std::string& serial, const std::string& description)
    : impl_(std::make_unique<Impl>()) {
  const TextFile file(description);
  impl_->camera.reset(arv_fake_camera_new_full(serial.c_str(), file.path()));
  GONIO_CHECK(impl_->camera, "no fake camera");
}

GigeMemory::~GigeMemory() = default;

std::uint32_t GigeMemory::Read(std::uint32_t address) const {
  const std::lock_guard lock(impl_->mutex);
  guint32 value = 0;
  arv_fake_camera_read_register(impl_->camera.get(), address, &value);
  return value;
}

void GigeMemory::Write(std::uint32_t address, std::uint32_t value) {
  const std::lock_guard lock(impl_->mutex);
  arv_fake_camera_write_register(impl_->camera.get(), address, value);
}

void GigeMemory::WriteText(std::uint32_t address, const std::string& text) {
  std::uint8_t field[32] = {};
  std::memcpy(field, text.data(), std::min(text.size(), sizeof field - 1));
  WriteBytes(address, field);
}

void GigeMemory::ReadBytes(std::uint32_t address, std::span<std::uint8_t> bytes) const {
  const std::lock_guard lock(impl_->mutex);
  std::fill(bytes.begin(), bytes.end(), std::uint8_t{0});
  arv_fake_camera_read_memory(impl_->camera.get(), address, bytes.size(), bytes.data());
}

void GigeMemory::WriteBytes(std::uint32_t address, std::span<const std::uint8_t> bytes) {
  const std::lock_guard lock(impl_->mutex);
  arv_fake_camera_write_memory(impl_->camera.get(), address, bytes.size(), bytes.data());
}

}  // namespace gonio
