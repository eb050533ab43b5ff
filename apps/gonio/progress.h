// SPDX-License-Identifier: Apache-2.0
// Progress and numbers on standard output.

#pragma once

#include <chrono>
#include <string>

#include "acquisition/session.h"
#include "apps/gonio/time_left.h"

namespace gonio {

// "0 s", "12 s", "3 min 20 s", "1 h 05 min": rounded, for people.
std::string ForPeople(Seconds duration);

// Shows the progress of a session or a study: on a terminal one line that is written over and over,
// with the time left; in a pipe a plain line every tenth of the way. Says nothing if quiet.
class ProgressLine {
 public:
  ProgressLine(std::string title, bool quiet);
  ~ProgressLine() { Finish(); }
  ProgressLine(const ProgressLine&) = delete;
  ProgressLine& operator=(const ProgressLine&) = delete;

  void Show(const Progress& progress);
  // `text`: what has been done, in words.
  void Show(int done, int total, const std::string& text);
  // Leaves the terminal's line clean.
  void Finish();

 private:
  std::string Left(int steps) const;

  std::string title_;
  bool quiet_;
  bool terminal_;
  bool dirty_ = false;
  int tenths_shown_ = 0;
  std::chrono::steady_clock::time_point begin_ = std::chrono::steady_clock::now();
  TimeLeft left_;
  std::chrono::steady_clock::time_point shown_{};
};

}  // namespace gonio
