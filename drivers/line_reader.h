// SPDX-License-Identifier: Apache-2.0
// Lines of text from a link, whatever pieces they arrive in.

#pragma once

#include <string>

#include "drivers/byte_link.h"

namespace gonio {

// Lines end with LF; a CR before it, or CRs alone, are dropped.
class LineReader {
 public:
  static constexpr std::size_t kMostBytes = 4096;  // of a line: no device of ours says more

  explicit LineReader(ByteLink* link) : link_(link) {}

  // The next line without its end. kTimeout: no end of line in time; what has come so far stays, to
  // be the beginning of the next line. kProtocol: more bytes than a line has; they are forgotten.
  Result<std::string> Next(Seconds limit);
  // Forgets what has come and was not read.
  Result<void> Discard();

 private:
  ByteLink* link_;
  std::string pending_;
};

}  // namespace gonio
