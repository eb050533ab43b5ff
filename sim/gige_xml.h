// SPDX-License-Identifier: Apache-2.0
// How a GigE Vision double describes itself to GenICam, and where its registers are.

#pragma once

#include <cstdint>
#include <string>

#include "sim/gige_camera.h"

namespace gonio {

// Addresses in GigeMemory: those below 0x1000 have their meaning at power-up already, the others
// are ours.
struct GigeRegisters {
  static constexpr std::uint32_t kAddress = 0x24;   // IPv4, of the camera
  static constexpr std::uint32_t kVendor = 0x48;    // text of 32 bytes
  static constexpr std::uint32_t kModel = 0x68;     // 32
  static constexpr std::uint32_t kFirmware = 0x88;  // 32
  static constexpr std::uint32_t kSerial = 0xD8;    // 16
  static constexpr std::uint32_t kWidth = 0x100;
  static constexpr std::uint32_t kHeight = 0x104;
  static constexpr std::uint32_t kSensorHeight = 0x118;
  static constexpr std::uint32_t kSensorWidth = 0x11C;
  static constexpr std::uint32_t kExposure = 0x120;  // us
  static constexpr std::uint32_t kAcquisition = 0x124;
  static constexpr std::uint32_t kPixelFormat = 0x128;
  static constexpr std::uint32_t kMode = 0x12C;
  static constexpr std::uint32_t kOffsetX = 0x130;
  static constexpr std::uint32_t kOffsetY = 0x134;
  static constexpr std::uint32_t kTriggerMode = 0x300;
  static constexpr std::uint32_t kTriggerSource = 0x304;
  static constexpr std::uint32_t kTriggerActivation = 0x308;
  static constexpr std::uint32_t kTriggerSoftware = 0x30C;
  static constexpr std::uint32_t kGain = 0x8000;         // 0.1 dB
  static constexpr std::uint32_t kBlackLevel = 0x8004;   // counts
  static constexpr std::uint32_t kTemperature = 0x8008;  // deg C, float
  static constexpr std::uint32_t kGainAuto = 0x800C;     // 0 off, 1 continuous
  static constexpr std::uint32_t kExposureAuto = 0x8010;
  static constexpr std::uint32_t kTriggerSelector = 0x8014;
  static constexpr std::uint32_t kChunkMode = 0x8018;
  static constexpr std::uint32_t kChunkSelector = 0x801C;
  static constexpr std::uint32_t kChunkEnable =
      0x8020;  // and the next: one per entry of the selector
  static constexpr std::uint32_t kCapability = 0x934;  // of the control channel
  static constexpr std::uint32_t kCanResend = 0x4;     // of kCapability
  // The stream channel.
  static constexpr std::uint32_t kStreamPort = 0xD00;  // of the client; lower 16 bits
  static constexpr std::uint32_t kPacketSize = 0xD04;  // bytes; lower 16 bits
  static constexpr std::uint32_t kStreamAddress = 0xD18;
};

// Numbers of the chunks that follow an image.
struct GigeChunks {
  static constexpr std::uint32_t kImage = 0x1;
  static constexpr std::uint32_t kExposure = 0xA1;  // us, a double
  static constexpr std::uint32_t kGain = 0xA2;      // dB, a double
  static constexpr std::uint32_t kBytes = 8;        // of each number
  static constexpr std::uint32_t kEndBytes = 8;     // that follow the data of each chunk
};

std::string GigeDescription(const GigeCameraSettings& settings);

}  // namespace gonio
