// SPDX-License-Identifier: Apache-2.0
#include "drivers/line_reader.h"

#include <fmt/format.h>

#include <algorithm>

#include "drivers/deadline.h"

namespace gonio {

Result<std::string> LineReader::Next(Seconds limit) {
  const Deadline deadline(limit);
  while (true) {
    if (const std::size_t end = pending_.find('\n'); end != std::string::npos) {
      std::string line = pending_.substr(0, end);
      pending_.erase(0, end + 1);
      std::erase(line, '\r');
      return line;
    }
    if (pending_.size() > kMostBytes) {
      pending_.clear();
      return Error{ErrorCode::kProtocol,
                   fmt::format("{}: {} bytes and no end of line", link_->name(), kMostBytes)};
    }
    const Result<std::string> more = link_->Read(kMostBytes, deadline.Left());
    if (!more && more.error().code == ErrorCode::kTimeout) {
      return Error{ErrorCode::kTimeout,
                   fmt::format("{}: no {} within {:.3g} s", link_->name(),
                               pending_.empty() ? "answer" : "end of the line", limit.count())};
    }
    if (!more) return more.error();
    pending_ += *more;
  }
}

Result<void> LineReader::Discard() {
  pending_.clear();
  return link_->DiscardInput();
}

}  // namespace gonio
