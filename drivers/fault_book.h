// SPDX-License-Identifier: Apache-2.0
// Faults that a controller tells once.

#pragma once

#include <map>
#include <string>

namespace gonio {

// Some controllers keep their errors in a queue that is emptied by reading. Whoever reads it, in
// whatever thread and for whichever axis, must not keep them from the axis they are about: so they
// are noted here until that axis has been homed. One thread at a time.
class FaultBook {
 public:
  static constexpr int kAll = 0;  // about every axis of the controller

  // `about`: an axis, or kAll.
  void Note(int about, const std::string& fault) { last_[about] = {++pages_, fault}; }
  // How many have been noted so far.
  int pages() const { return pages_; }
  // The last one about `axis`, or about all, after the first `pages`; empty: there is none.
  std::string After(int pages, int axis) const {
    Fault found{pages, {}};
    for (const int about : {kAll, axis}) {
      const auto fault = last_.find(about);
      if (fault != last_.end() && fault->second.page > found.page) found = fault->second;
    }
    return found.text;
  }

 private:
  struct Fault {
    int page = 0;
    std::string text;
  };

  int pages_ = 0;
  std::map<int, Fault> last_;
};

}  // namespace gonio
