// SPDX-License-Identifier: Apache-2.0
// What SQLite drops in silence when it opens a database that was not closed.

#pragma once

#include <filesystem>

namespace gonio {

// Frames (pages with a header) in a write-ahead log, by the format at sqlite.org/walformat.html.
struct WalTail {
  int committed = 0;   // up to the last whole transaction
  int unfinished = 0;  // after it, sound or cut short: a transaction that was not committed
  // Of the same log, with a wrong checksum, and what follows: SQLite drops it. A single one may
  // also have been in the middle of being written over that of an earlier round.
  int damaged = 0;
};

// Zeros if there is no such file or it is empty. To be asked before the database is opened to
// write, which empties the log.
WalTail ReadWalTail(const std::filesystem::path& wal);

}  // namespace gonio
