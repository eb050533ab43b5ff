// SPDX-License-Identifier: Apache-2.0
// gonio rescue: what is damaged in a session, and a new one of what is not.

#include <fmt/format.h>

#include "acquisition/session_check.h"
#include "apps/gonio/commands.h"

namespace gonio {

int RescueCommand(const RescueOptions& options) {
  const std::vector<std::string> damage = FindDamage(options.session);
  for (const std::string& one : damage) fmt::print("damage           {}\n", one);
  if (damage.empty()) fmt::print("damage           none: every page and frame is as written\n");
  if (options.out.empty()) return damage.empty() ? kDone : kFailed;
  const Rescued rescued = RescueSession(options.session, options.out);
  for (const std::string& one : rescued.lost) fmt::print("lost             {}\n", one);
  fmt::print("kept             {} poses, {} lost\nwrote            {}\n", rescued.poses,
             rescued.lost_poses, options.out.string());
  return rescued.lost.empty() ? kDone : kFailed;
}

}  // namespace gonio
