// SPDX-License-Identifier: Apache-2.0
// Where a camera and a light truly are, from images of a board and of a mirror: one least-squares
// problem over all views (docs/geometry.md, "Calibration").

#pragma once

#include <Eigen/Core>
#include <array>
#include <string>
#include <vector>

#include "acquisition/geometry_calibration/find_target.h"
#include "acquisition/radiometry/measured_value.h"
#include "acquisition/rig.h"
#include "brdf/imaging.h"
#include "core/error.h"

namespace gonio {

// What one image of the board showed.
struct BoardView {
  ArmAngles arms{};                      // encoders
  std::vector<Eigen::Vector2d> corners;  // px, row by row, as FindCorners() gives them
};

// Of the mirror.
struct MirrorView {
  ArmAngles arms{};
  Eigen::Vector2d highlight = Eigen::Vector2d::Zero();  // px
};

// The unknowns, in this order in the covariance. Angles in rad, lengths in m, offsets are true
// minus encoder. Of the light and the mirror only if there were mirror views.
enum GeometryUnknown {
  kFocalLength,  // px
  kPrincipalX,   // px
  kPrincipalY,   // px
  kRadialDistortion,
  kCameraTurnX,  // about right, down, forward: of the camera on its arm
  kCameraTurnY,
  kCameraTurnZ,
  kCameraAzimuthOffset,  // against the board's columns, which are the sample's x by definition
  kCameraElevationOffset,
  kCameraDistance,
  kBoardTiltX,  // of the board against the azimuth axes
  kBoardTiltY,
  kBoardX,
  kBoardY,
  kBoardZ,
  kLightAzimuthOffset,
  kLightElevationOffset,
  kLightDistance,
  kMirrorTiltX,
  kMirrorTiltY,
  kMirrorZ,
  kGeometryUnknowns
};
inline constexpr int kCameraUnknowns = kLightAzimuthOffset;
// As in files.
extern const char* const kGeometryNames[kGeometryUnknowns];

using GeometryValues = std::array<double, kGeometryUnknowns>;

struct GeometryFit {
  std::array<MeasuredValue, kGeometryUnknowns> unknowns{};
  // Of the unknowns; rows and columns of those that were not fitted are zero.
  Eigen::MatrixXd covariance;
  bool has_light = false;
  bool distorted =
      false;              // radial distortion was more than twice its uncertainty, or was left at 0
  double board_rms = 0;   // px, of a coordinate of a corner
  double mirror_rms = 0;  // px, of a coordinate of a highlight
  int board_views = 0;    // used
  int mirror_views = 0;   // used
  std::vector<std::string> left_out;  // "board view 7: 3.1 px rms", ...

  double operator[](GeometryUnknown unknown) const { return unknowns[unknown].value; }
  // Standard uncertainty of the directions of the light and the camera at these arms [rad]: of
  // either of the two angles across it, the larger.
  double SigmaOfDirections(const ArmAngles& arms) const;
};

// What the rig file believes.
struct GeometryBelief {
  Imaging imaging;
  int width = 0;  // of the region that is read out, px
  int height = 0;
};

// Where a rig of these values sees the corners, row by row, and the light's mirror image [px]. Of
// the belief only the size of the image counts.
std::vector<Eigen::Vector2d> ProjectCorners(const GeometryValues& values,
                                            const GeometryBelief& belief, const Checkerboard& board,
                                            const ArmAngles& arms);
Eigen::Vector2d ProjectHighlight(const GeometryValues& values, const GeometryBelief& belief,
                                 const ArmAngles& arms);
// Where the corners, and the light's mirror image, are believed to be.
std::vector<Eigen::Vector2d> PredictCorners(const GeometryBelief& belief, const Checkerboard& board,
                                            const ArmAngles& arms);
Eigen::Vector2d PredictHighlight(const GeometryBelief& belief, const ArmAngles& arms);

inline constexpr int kLeastBoardViews = 6;
inline constexpr int kLeastMirrorViews = 5;

// kRefused: too few views that agree, or the views leave an unknown open (all from one side, say).
// A view whose residuals are far beyond the others' is left out and named. Without mirror views
// only the camera is found.
Result<GeometryFit> FitGeometry(const GeometryBelief& belief, const Checkerboard& board,
                                const std::vector<BoardView>& boards,
                                const std::vector<MirrorView>& mirrors);

}  // namespace gonio
