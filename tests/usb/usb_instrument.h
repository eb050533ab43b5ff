// SPDX-License-Identifier: Apache-2.0
// What tests plug in and open.

#pragma once

#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <utility>

#include "drivers/thorlabs.h"
#include "drivers/usbtmc.h"
#include "sim/usb_bench.h"
#include "sim/usbtmc_emulator.h"

namespace gonio {

// Waited out only where something is silent.
inline constexpr Seconds kShortLimit{0.25};
// Never waited for unless a test fails.
inline constexpr Seconds kLongLimit{10};

inline UsbPlate PlateOf(int product, const std::string& serial) {
  return {.vendor = kThorlabsVendor,
          .product = product,
          .maker = "Thorlabs",
          .description = "Instrument",
          .serial = serial};
}

inline std::unique_ptr<UsbtmcDevice> OpenedDevice(const UsbPlate& plate) {
  auto device = UsbtmcDevice::Open(
      {.vendor = plate.vendor, .products = {plate.product}, .serial = plate.serial});
  EXPECT_TRUE(device.ok()) << (device.ok() ? "" : device.error().message);
  return device.ok() ? std::move(device).value() : nullptr;
}

}  // namespace gonio
