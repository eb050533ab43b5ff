// SPDX-License-Identifier: Apache-2.0
// What SQLite drops in silence when it opens a database that was not closed.

#pragma once

#include <filesystem>

namespace gonio {

// Frames (pages with a header) in a write-ahead log, by the format at sqlite.org/walformat.html.
struct WalTail {
  int committed = 0;   // up to the last whole transaction
  int unfinished = 0;  // after it, sound: a transaction that was not committed
  int damaged = 0;     // of the same log, with a wrong checksum, and what follows: SQLite drops it
};

// Zeros if there is no such file or it is empty. To be asked before the database is opened to
// write, which empties the log.
WalTail ReadWalTail(const std::filesystem::path& wal);

}  // namespace gonio
