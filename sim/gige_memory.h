// SPDX-License-Identifier: Apache-2.0
// The registers of a GigE Vision double, and the description of them that it keeps for its clients.

#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>

namespace gonio {

// 64 KiB as they are at power-up, and behind them the description. They are Aravis' fake camera's,
// which knows the bootstrap registers that every GigE Vision camera has.
//
// Any thread. Addresses outside read as 0 and are not written.
class GigeMemory {
 public:
  GigeMemory(const std::string& serial, const std::string& description);
  ~GigeMemory();

  std::uint32_t Read(std::uint32_t address) const;
  void Write(std::uint32_t address, std::uint32_t value);
  void WriteText(std::uint32_t address, const std::string& text);  // a field of 32 bytes
  void ReadBytes(std::uint32_t address, std::span<std::uint8_t> bytes) const;
  void WriteBytes(std::uint32_t address, std::span<const std::uint8_t> bytes);

 private:
  struct Impl;
  const std::unique_ptr<Impl> impl_;
};

}  // namespace gonio
