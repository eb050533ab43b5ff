// SPDX-License-Identifier: Apache-2.0
// Which of Thorlabs' instruments on USB we know.

#pragma once

#include <vector>

namespace gonio {

inline constexpr int kThorlabsVendor = 0x1313;

// Most have two product numbers: with and without a second interface for new firmware, which we do
// not touch. Both are the working instrument.
inline const std::vector<int> kDc2200Products = {0x80c8, 0x80c0};
inline const std::vector<int> kPowerMeterProducts = {
    0x8070, 0x8078,  // PM100D
    0x8071, 0x8079,  // PM100A
    0x8072,          // PM100USB
    0x8073, 0x807b,  // PM160
    0x8074, 0x807c,  // PM160T
    0x8075, 0x807d,  // PM400
    0x807a,          // PM103
    0x807e,          // PM103E
    0x80b0,          // PM200
    0x80bb,          // PM5020
};

}  // namespace gonio
