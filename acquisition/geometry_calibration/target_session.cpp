// SPDX-License-Identifier: Apache-2.0
#include "acquisition/geometry_calibration/target_session.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "acquisition/frame_taker.h"
#include "acquisition/geometry_calibration/target_poses.h"
#include "acquisition/light_colours.h"
#include "acquisition/motion.h"
#include "acquisition/path_planner.h"
#include "core/config.h"
#include "core/file.h"

namespace gonio {
namespace {

using nlohmann::json;

// Of the full scale, for the brightest pixel: what is accepted, and what is aimed at.
constexpr double kLeast = 0.35;
constexpr double kMost = 0.9;
constexpr double kAim = 0.65;
constexpr int kTries = 10;

class Photographer {
 public:
  explicit Photographer(const TargetSession& session)
      : session_(session),
        taker_(session.rig, session.devices),
        colours_(session.rig, session.devices, session.clock),
        paths_(session.rig) {}

  Result<void> Prepare() {
    if (auto homed = HomeAll(session_.rig.motion, session_.devices, session_.stop); !homed)
      return homed;
    auto lit = session_.devices.light->SetLevel(session_.rig.light_level);
    // Targets are black and white: one colour of a light that has them will do.
    if (!lit || !session_.rig.by_colour) return lit;
    return colours_.Select(LightColour::kGreen, session_.stop);
  }

  // Where the arms came to stand, and the image there.
  Result<Frame> At(const ArmAngles& target, ArmAngles& readback) {
    const auto from = ReadPositions(session_.devices);
    if (!from) return from.error();
    const auto path = paths_.Plan(*from, target);
    if (!path) return path.error();
    auto arrival = MoveAlong(session_.rig, session_.devices, session_.clock, *path, session_.stop);
    if (!arrival) return arrival.error();
    readback = arrival->readback;
    return Expose();
  }

 private:
  double Peak(const Frame& frame) const {
    const auto most = *std::max_element(frame.counts.begin(), frame.counts.end());
    return most >= session_.rig.camera.full_scale
               ? 2
               : (most - frame.black_level) / (session_.rig.camera.full_scale - frame.black_level);
  }

  Result<Frame> Expose() {
    const CameraInfo& camera = session_.rig.camera;
    Result<Frame> last = Error{ErrorCode::kRefused, "no exposure"};
    for (int i = 0; i < kTries; ++i) {
      exposure_ = std::clamp(exposure_, camera.min_exposure, camera.max_exposure);
      const auto monitor = taker_.ReadMonitor();
      if (!monitor) return monitor.error();
      auto taken = taker_.Take(exposure_, *monitor, session_.stop);
      if (!taken) return taken.error();
      last = std::move(taken->frame);
      const double peak = Peak(*last);
      if (peak >= kLeast && peak <= kMost) return last;
      const Seconds before = exposure_;
      exposure_ *= peak > 1 ? 0.1 : std::clamp(kAim / std::max(peak, 1e-3), 0.1, 50.0);
      exposure_ = std::clamp(exposure_, camera.min_exposure, camera.max_exposure);
      if (exposure_ == before) return last;  // as bright as it gets, or as dark
    }
    return last;
  }

  const TargetSession& session_;
  FrameTaker taker_;
  ColourChanger colours_;
  const PathPlanner paths_;
  Seconds exposure_{0.01};
};

// `look` says what it found in a frame, or "" and why not.
template <typename Look>
Result<void> Visit(const TargetSession& session, const std::vector<ArmAngles>& poses, int least,
                   const char* target, const Look& look) {
  const int count = static_cast<int>(poses.size());
  if (count < least) {
    return Error{ErrorCode::kRefused, fmt::format("only {} poses of the {} are within the arms' "
                                                  "limits; {} are needed",
                                                  count, target, least)};
  }
  Photographer photographer(session);
  if (auto ready = photographer.Prepare(); !ready) return ready;
  int seen = 0;
  for (int i = 0; i < count; ++i) {
    ArmAngles readback{};
    auto frame = photographer.At(poses[i], readback);
    std::string note;
    if (frame) {
      seen += look(*frame, readback, note) ? 1 : 0;
    } else if (frame.error().code == ErrorCode::kRefused) {
      note = frame.error().message;
    } else {
      (void)StopAll(session.devices);
      (void)session.devices.light->SetLevel(0);
      return frame.error();
    }
    if (session.progress) session.progress(i + 1, count, note);
  }
  if (auto off = session.devices.light->SetLevel(0); !off) return off;
  if (seen >= least) return {};
  return Error{ErrorCode::kRefused, fmt::format("the {} was seen in {} of {} views; {} are needed",
                                                target, seen, count, least)};
}

json ToJson(const ArmAngles& arms) { return json(arms); }

}  // namespace

Result<std::vector<BoardView>> PhotographBoard(const TargetSession& session,
                                               const Checkerboard& board) {
  const RigConfig& rig = session.rig;
  const GeometryBelief belief{rig.imaging, rig.camera.width, rig.camera.height};
  std::vector<BoardView> views;
  const auto look = [&](const Frame& frame, const ArmAngles& arms, std::string& note) {
    const auto corners =
        FindCorners(frame, rig.camera.full_scale, board, PredictCorners(belief, board, arms));
    note = corners ? fmt::format("{} corners", corners->size()) : "no board";
    if (corners) views.push_back({arms, *corners});
    return corners.has_value();
  };
  if (auto done = Visit(session, BoardPoses(rig), kLeastBoardViews, "board", look); !done) {
    return done.error();
  }
  return views;
}

Result<std::vector<MirrorView>> PhotographMirror(const TargetSession& session) {
  const RigConfig& rig = session.rig;
  std::vector<MirrorView> views;
  const auto look = [&](const Frame& frame, const ArmAngles& arms, std::string& note) {
    const auto highlight = FindHighlight(frame, rig.camera.full_scale);
    note = highlight ? fmt::format("highlight at {:.1f}, {:.1f}", highlight->x(), highlight->y())
                     : highlight.error().message;
    if (highlight) views.push_back({arms, *highlight});
    return static_cast<bool>(highlight);
  };
  if (auto done = Visit(session, MirrorPoses(rig), kLeastMirrorViews, "mirror", look); !done) {
    return done.error();
  }
  return views;
}

void WriteViews(const std::filesystem::path& path, const TargetViews& views) {
  json all = {{"version", 1},
              {"kind", "geometry-views"},
              {"camera", views.camera},
              {"board",
               {{"columns", views.board.columns},
                {"rows", views.board.rows},
                {"square_m", views.board.square}}},
              {"boards", json::array()},
              {"mirrors", json::array()}};
  for (const BoardView& view : views.boards) {
    json corners = json::array();
    for (const Eigen::Vector2d& corner : view.corners) corners.push_back({corner.x(), corner.y()});
    all["boards"].push_back({{"arms_rad", ToJson(view.arms)}, {"corners_px", corners}});
  }
  for (const MirrorView& view : views.mirrors) {
    all["mirrors"].push_back({{"arms_rad", ToJson(view.arms)},
                              {"highlight_px", {view.highlight.x(), view.highlight.y()}}});
  }
  WriteFileAtomically(path, [&](std::ostream& out) { out << all.dump(1) << '\n'; });
}

TargetViews ReadViews(const std::filesystem::path& path) {
  try {
    const json all = json::parse(ReadTextFile(path));
    if (all.at("version") != 1 || all.at("kind") != "geometry-views") {
      throw ConfigError(path.string() + ": has no views of a geometry calibration");
    }
    TargetViews views;
    views.camera = all.at("camera").get<std::string>();
    const json& board = all.at("board");
    views.board = {board.at("columns").get<int>(), board.at("rows").get<int>(),
                   board.at("square_m").get<double>()};
    const auto point = [](const json& p) {
      return Eigen::Vector2d(p.at(0).get<double>(), p.at(1).get<double>());
    };
    for (const json& seen : all.at("boards")) {
      BoardView view{seen.at("arms_rad").get<ArmAngles>(), {}};
      for (const json& corner : seen.at("corners_px")) view.corners.push_back(point(corner));
      if (static_cast<int>(view.corners.size()) != views.board.corners()) {
        throw ConfigError(path.string() + ": a view has not all corners");
      }
      views.boards.push_back(std::move(view));
    }
    for (const json& seen : all.at("mirrors")) {
      views.mirrors.push_back(
          {seen.at("arms_rad").get<ArmAngles>(), point(seen.at("highlight_px"))});
    }
    return views;
  } catch (const json::exception& e) {
    throw ConfigError(fmt::format("{}: is damaged: {}", path.string(), e.what()));
  }
}

}  // namespace gonio
