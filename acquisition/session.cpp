// SPDX-License-Identifier: Apache-2.0
#include "acquisition/session.h"

#include "acquisition/session_loop.h"

namespace gonio {

SessionSummary RunSession(const SessionParts& parts, const SessionOptions& options,
                          const SessionStop& stop, const ProgressFunction& progress) {
  options.Check();
  return SessionLoop(parts, options, stop, progress).Run();
}

}  // namespace gonio
