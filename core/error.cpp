// SPDX-License-Identifier: Apache-2.0
#include "core/error.h"

namespace gonio {

const char* ToString(ErrorCode code) {
  switch (code) {
    case ErrorCode::kTimeout:
      return "timeout";
    case ErrorCode::kDisconnected:
      return "disconnected";
    case ErrorCode::kProtocol:
      return "protocol";
    case ErrorCode::kRefused:
      return "refused";
    case ErrorCode::kCancelled:
      return "cancelled";
    case ErrorCode::kStorage:
      return "storage";
    case ErrorCode::kEmergencyStop:
      return "emergency stop";
  }
  return "unknown";
}

}  // namespace gonio
