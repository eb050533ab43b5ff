// SPDX-License-Identifier: Apache-2.0
// What to do where the system keeps a device from this user: said when one cannot be opened, and by
// gonio doctor before that.

#pragma once

#include <string>

namespace gonio {

// For an instrument, and for adapters that are slow without them.
inline const std::string kInstallRules =
    "copy 60-goniopilot.rules into /etc/udev/rules.d, run udevadm control --reload, and plug it in "
    "again";

inline const std::string kNoUsbPermission = "no permission; " + kInstallRules;

inline const std::string kNoPortPermission =
    "no permission; add yourself to the group that owns it, dialout as a rule: adduser $USER "
    "dialout, and log in again";

}  // namespace gonio
