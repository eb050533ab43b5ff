// SPDX-License-Identifier: Apache-2.0
#include "acquisition/session_costs.h"

#include <algorithm>
#include <array>
#include <memory>
#include <optional>

#include "acquisition/exposure.h"
#include "acquisition/image_regions.h"
#include "acquisition/kinematics.h"
#include "acquisition/light_colours.h"
#include "acquisition/radiometry.h"
#include "acquisition/time_estimate.h"

namespace gonio {
namespace {

constexpr int kPartsPixels = 64;

// Where the arms stand at the poses moves begin at: planners ask for thousands of moves from each.
class Starts {
 public:
  explicit Starts(const RigConfig& rig) : kinematics_(rig) {}

  const Kinematics& kinematics() const { return kinematics_; }

  const std::optional<AxisPositions>& At(const DirectionPair& pair) {
    for (const Start& start : starts_) {
      if (start.known && start.pair.wi == pair.wi && start.pair.wo == pair.wo) return start.angles;
    }
    Start& start = starts_[next_];
    next_ = (next_ + 1) % starts_.size();
    start = {true, pair, kinematics_.Inverse(pair, AxisPositions{})};
    return start.angles;
  }

 private:
  struct Start {
    bool known = false;
    DirectionPair pair;
    std::optional<AxisPositions> angles;
  };
  const Kinematics kinematics_;
  std::array<Start, 16> starts_;
  std::size_t next_ = 0;
};

// The first frame of a pose where f_r is foretold, for each channel [s]: the same one, or one in
// each colour.
Rgb FramesFor(const DirectionPair& pair, const Rgb& f_r, const RigConfig& rig) {
  const double cos_theta_i = std::max(pair.cos_theta_i(), 0.0);
  const Rgb rates = CountRates(f_r, cos_theta_i, rig.light_level, rig.radiometry);
  if (!rig.by_colour) return Rgb::Constant(FirstExposure(rates, rig).count());
  Rgb exposures;
  for (int c = 0; c < kChannels; ++c) {
    Rgb own = Rgb::Zero();
    own[c] = rates[c];
    exposures[c] = FirstExposure(own, rig).count();
  }
  return exposures;
}

// Of one such frame, or three.
double SecondsOf(const Rgb& exposures, const RigConfig& rig) {
  if (!rig.by_colour) return (Seconds(exposures[0]) + ReadoutOf(rig)).count();
  return exposures.sum() + kChannels * ReadoutOf(rig).count();
}

}  // namespace

SessionCosts CostsOn(const RigConfig& rig) {
  SessionCosts costs;
  costs.travel = [starts = std::make_shared<Starts>(rig)](const DirectionPair& from,
                                                          const DirectionPair& to) {
    const std::optional<AxisPositions>& start = starts->At(from);
    if (!start) return 0.0;
    const std::optional<AxisPositions> end = starts->kinematics().Inverse(to, *start);
    return end ? starts->kinematics().TravelTime(*start, *end).count() : 0.0;
  };
  costs.frame = [rig](const DirectionPair& pair, const Rgb& f_r) {
    return SecondsOf(FramesFor(pair, f_r, rig), rig);
  };
  costs.pose = [frame = costs.frame, standing = (StandingOf(rig) + ColourChangesOf(rig)).count()](
                   const DirectionPair& pair, const Rgb& f_r) {
    return standing + frame(pair, f_r);
  };
  costs.max_frames = rig.exposure.max_frames;
  return costs;
}

ExpectedNoise NoiseOn(const RigConfig& rig) {
  return [rig](const DirectionPair& pair, const Rgb& f_r) {
    return ExpectedSigma(pair, f_r, FramesFor(pair, f_r, rig), rig);
  };
}

PartsOf PartsOn(const RigConfig& rig) {
  if (rig.samples_per_image == 1) return {};
  const int shrink = std::max(1, std::max(rig.camera.width, rig.camera.height) / kPartsPixels);
  Imaging imaging = rig.imaging;
  imaging.focal_length /= shrink;
  return [kinematics = Kinematics(rig), imaging, width = rig.camera.width / shrink,
          height = rig.camera.height / shrink, max_polar = rig.geometry.max_polar,
          count = rig.samples_per_image](const DirectionPair& pair) {
    std::vector<DirectionPair> parts;
    const auto axes = kinematics.Inverse(pair, AxisPositions{});
    if (!axes) return parts;
    const ArmAngles arms = kinematics.TrueAngles(*axes);
    for (const ImageRegion& region :
         RegionsOf(kinematics.ImagingAt(imaging, *axes), arms, width, height, max_polar, count)) {
      parts.push_back(region.directions);
    }
    return parts;
  };
}

}  // namespace gonio
