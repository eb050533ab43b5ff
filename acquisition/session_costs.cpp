// SPDX-License-Identifier: Apache-2.0
#include "acquisition/session_costs.h"

#include <array>
#include <memory>
#include <optional>

#include "acquisition/exposure.h"
#include "acquisition/kinematics.h"

namespace gonio {
namespace {

// Where the arms stand at the poses moves begin at: planners ask for thousands of moves from each.
class Starts {
 public:
  explicit Starts(const RigConfig& rig) : kinematics_(rig) {}

  const Kinematics& kinematics() const { return kinematics_; }

  const std::optional<ArmAngles>& At(const DirectionPair& pair) {
    for (const Start& start : starts_) {
      if (start.known && start.pair.wi == pair.wi && start.pair.wo == pair.wo) return start.angles;
    }
    Start& start = starts_[next_];
    next_ = (next_ + 1) % starts_.size();
    start = {true, pair, kinematics_.Inverse(pair, ArmAngles{})};
    return start.angles;
  }

 private:
  struct Start {
    bool known = false;
    DirectionPair pair;
    std::optional<ArmAngles> angles;
  };
  const Kinematics kinematics_;
  std::array<Start, 16> starts_;
  std::size_t next_ = 0;
};

}  // namespace

SessionCosts CostsOn(const RigConfig& rig) {
  SessionCosts costs;
  costs.travel = [starts = std::make_shared<Starts>(rig)](const DirectionPair& from,
                                                          const DirectionPair& to) {
    const std::optional<ArmAngles>& start = starts->At(from);
    if (!start) return 0.0;
    const std::optional<ArmAngles> end = starts->kinematics().Inverse(to, *start);
    return end ? starts->kinematics().TravelTime(*start, *end).count() : 0.0;
  };
  costs.pose = [rig](const DirectionPair& pair, const Rgb& f_r) {
    const RadiometryConfig& r = rig.radiometry;
    const Rgb rates =
        r.responsivity * f_r * (pair.cos_theta_i() * rig.light_level / r.electrons_per_count);
    return (rig.motion.settle + FirstExposure(rates, rig) + rig.camera.readout).count();
  };
  return costs;
}

}  // namespace gonio
