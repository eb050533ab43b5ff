// SPDX-License-Identifier: Apache-2.0
#include "acquisition/geometry_calibration/bundle.h"

#include <ceres/ceres.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "acquisition/geometry_calibration/projection.h"

namespace gonio {
namespace {

using Unknowns = GeometryValues;
// A view whose residuals are so many times the median view's is not of the same rig.
constexpr double kOutlier = 4;
// px; a residual beyond it pulls no harder, as long as views have not been judged.
constexpr double kHuber = 1;
// Of a coordinate, px: no image is better than that, nor are the encoders.
constexpr double kLeastSigma = 1e-4;

struct CornerResidual {
  ArmAngles arms;
  Sensor sensor;
  Eigen::Vector2d corner;
  Eigen::Vector2d seen;
  double sigma;

  template <typename T>
  bool operator()(const T* u, T* residual) const {
    const Vector2<T> at = Project<T>(u, arms, sensor, OnBoard(u, corner));
    residual[0] = (at.x() - seen.x()) / sigma;
    residual[1] = (at.y() - seen.y()) / sigma;
    return true;
  }
};

struct HighlightResidual {
  ArmAngles arms;
  Sensor sensor;
  Eigen::Vector2d seen;
  double sigma;

  template <typename T>
  bool operator()(const T* u, T* residual) const {
    const Vector2<T> at = Project<T>(u, arms, sensor, MirroredLight(u, arms));
    residual[0] = (at.x() - seen.x()) / sigma;
    residual[1] = (at.y() - seen.y()) / sigma;
    return true;
  }
};

Sensor SensorOf(const GeometryBelief& belief) {
  return {belief.width / 2.0 - 0.5, belief.height / 2.0 - 0.5};
}

Unknowns Believed(const Imaging& imaging) {
  Unknowns u{};
  u[kFocalLength] = imaging.focal_length;
  u[kPrincipalX] = imaging.principal_x;
  u[kPrincipalY] = imaging.principal_y;
  for (int i = 0; i < 3; ++i) u[kCameraTurnX + i] = imaging.camera_turn[i];
  u[kCameraDistance] = imaging.camera_distance;
  u[kLightDistance] = imaging.light_distance;
  return u;
}

double RootMean(double sum, double count) { return std::sqrt(sum / std::max(count, 1.0)); }

// The views that still count, and how well their images are known.
class Bundle {
 public:
  Bundle(const GeometryBelief& belief, const Checkerboard& board,
         const std::vector<BoardView>& boards, const std::vector<MirrorView>& mirrors)
      : sensor_(SensorOf(belief)), board_(board), boards_(boards), mirrors_(mirrors) {
    u_ = Believed(belief.imaging);
    for (std::size_t i = 0; i < boards.size(); ++i) used_boards_.insert(i);
    for (std::size_t i = 0; i < mirrors.size(); ++i) used_mirrors_.insert(i);
  }

  Result<GeometryFit> Fit();

 private:
  bool has_light() const { return !mirrors_.empty(); }
  Result<void> CheckCounts() const;
  Result<void> Solve(bool robust);
  void Reweigh();
  bool LeaveOut();
  Result<void> AddCovariance(ceres::Problem& problem, GeometryFit& fit);
  std::vector<int> Fixed() const;
  void Add(ceres::Problem& problem, bool robust);
  double BoardSquares(std::size_t view) const;
  double MirrorSquares(std::size_t view) const;
  double BoardSum() const;
  double MirrorSum() const;
  int Free() const { return kGeometryUnknowns - static_cast<int>(Fixed().size()); }

  const Sensor sensor_;
  const Checkerboard& board_;
  const std::vector<BoardView>& boards_;
  const std::vector<MirrorView>& mirrors_;
  std::set<std::size_t> used_boards_;
  std::set<std::size_t> used_mirrors_;
  Unknowns u_{};
  bool straight_ = true;  // radial distortion stays 0
  double board_sigma_ = 0.1;
  double mirror_sigma_ = 0.1;
  std::vector<std::string> left_out_;
};

double Bundle::BoardSquares(std::size_t view) const {
  double sum = 0;
  int i = 0;
  for (const Eigen::Vector2d& seen : boards_[view].corners) {
    const Eigen::Vector2d corner = board_.Corner(i % board_.columns, i / board_.columns);
    sum +=
        (Project<double>(u_.data(), boards_[view].arms, sensor_, OnBoard(u_.data(), corner)) - seen)
            .squaredNorm();
    ++i;
  }
  return sum;
}

double Bundle::MirrorSquares(std::size_t view) const {
  const MirrorView& mirror = mirrors_[view];
  return (Project<double>(u_.data(), mirror.arms, sensor_, MirroredLight(u_.data(), mirror.arms)) -
          mirror.highlight)
      .squaredNorm();
}

double Bundle::BoardSum() const {
  double sum = 0;
  for (const std::size_t view : used_boards_) sum += BoardSquares(view);
  return sum;
}

double Bundle::MirrorSum() const {
  double sum = 0;
  for (const std::size_t view : used_mirrors_) sum += MirrorSquares(view);
  return sum;
}

std::vector<int> Bundle::Fixed() const {
  std::vector<int> fixed;
  if (straight_) fixed.push_back(kRadialDistortion);
  if (!has_light()) {
    for (int i = kLightAzimuthOffset; i < kGeometryUnknowns; ++i) fixed.push_back(i);
  }
  return fixed;
}

void Bundle::Add(ceres::Problem& problem, bool robust) {
  ceres::LossFunction* loss = robust ? new ceres::HuberLoss(kHuber / board_sigma_) : nullptr;
  for (const std::size_t view : used_boards_) {
    int i = 0;
    for (const Eigen::Vector2d& seen : boards_[view].corners) {
      const Eigen::Vector2d corner = board_.Corner(i % board_.columns, i / board_.columns);
      ++i;
      problem.AddResidualBlock(
          new ceres::AutoDiffCostFunction<CornerResidual, 2, kGeometryUnknowns>(
              new CornerResidual{boards_[view].arms, sensor_, corner, seen, board_sigma_}),
          loss, u_.data());
    }
  }
  // The problem owns a loss only once a residual has it.
  ceres::LossFunction* other =
      robust && has_light() ? new ceres::HuberLoss(kHuber / mirror_sigma_) : nullptr;
  for (const std::size_t view : used_mirrors_) {
    problem.AddResidualBlock(
        new ceres::AutoDiffCostFunction<HighlightResidual, 2, kGeometryUnknowns>(
            new HighlightResidual{mirrors_[view].arms, sensor_, mirrors_[view].highlight,
                                  mirror_sigma_}),
        other, u_.data());
  }
  const std::vector<int> fixed = Fixed();
  if (fixed.empty()) return;
#if CERES_VERSION_MAJOR > 2 || CERES_VERSION_MINOR > 0
  problem.SetManifold(u_.data(), new ceres::SubsetManifold(kGeometryUnknowns, fixed));
#else  // Ubuntu 22.04
  problem.SetParameterization(u_.data(),
                              new ceres::SubsetParameterization(kGeometryUnknowns, fixed));
#endif
}

Result<void> Bundle::Solve(bool robust) {
  ceres::Problem problem;
  Add(problem, robust);
  ceres::Solver::Options options;
  options.linear_solver_type = ceres::DENSE_QR;
  options.max_num_iterations = 200;
  options.function_tolerance = 1e-12;
  options.parameter_tolerance = 1e-12;
  options.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(options, &problem, &summary);
  if (summary.IsSolutionUsable()) return {};
  return Error{ErrorCode::kRefused, "the views fit no rig: " + summary.message};
}

// Corners and highlights are as sure as their own residuals say: the unknowns are shared out among
// both by what each contributes, nearly.
void Bundle::Reweigh() {
  const double corners = 2.0 * used_boards_.size() * board_.corners();
  board_sigma_ = std::max(RootMean(BoardSum(), corners - kCameraUnknowns), kLeastSigma);
  if (!has_light()) return;
  const double highlights = 2.0 * used_mirrors_.size();
  mirror_sigma_ = std::max(
      RootMean(MirrorSum(), highlights - (kGeometryUnknowns - kCameraUnknowns)), kLeastSigma);
}

// Takes out the views that are far beyond the others; false: there are none.
bool Bundle::LeaveOut() {
  const std::size_t before = left_out_.size();
  const auto judge = [&](std::set<std::size_t>& used, const char* kind, double count,
                         const auto& squares) {
    if (used.empty()) return;
    std::vector<float> rms;
    for (const std::size_t view : used) {
      rms.push_back(static_cast<float>(RootMean(squares(view), count)));
    }
    const double limit = kOutlier * std::max(Median(rms), 0.01);
    const std::vector<std::size_t> views(used.begin(), used.end());
    for (std::size_t i = 0; i < views.size(); ++i) {
      if (rms[i] <= limit) continue;
      used.erase(views[i]);
      left_out_.push_back(fmt::format("{} view {}: {:.2f} px rms", kind, views[i] + 1, rms[i]));
    }
  };
  judge(used_boards_, "board", 2.0 * board_.corners(),
        [&](std::size_t view) { return BoardSquares(view); });
  judge(used_mirrors_, "mirror", 2, [&](std::size_t view) { return MirrorSquares(view); });
  return left_out_.size() > before;
}

Result<void> Bundle::CheckCounts() const {
  const auto few = [](const char* target, std::size_t have, int need) {
    return Error{ErrorCode::kRefused,
                 fmt::format("{} usable views of the {}; {} are needed", have, target, need)};
  };
  if (used_boards_.size() < kLeastBoardViews) {
    return few("board", used_boards_.size(), kLeastBoardViews);
  }
  if (has_light() && used_mirrors_.size() < kLeastMirrorViews) {
    return few("mirror", used_mirrors_.size(), kLeastMirrorViews);
  }
  return {};
}

Result<void> Bundle::AddCovariance(ceres::Problem& problem, GeometryFit& fit) {
  ceres::Covariance::Options options;
  options.algorithm_type = ceres::DENSE_SVD;
  options.null_space_rank = 0;
  options.min_reciprocal_condition_number = 1e-20;
  ceres::Covariance covariance(options);
  const std::vector<std::pair<const double*, const double*>> blocks = {{u_.data(), u_.data()}};
  if (!covariance.Compute(blocks, &problem)) {
    return Error{ErrorCode::kRefused,
                 "the views leave an unknown open: they need several elevations and azimuths"};
  }
  Eigen::Matrix<double, kGeometryUnknowns, kGeometryUnknowns, Eigen::RowMajor> matrix;
  covariance.GetCovarianceBlock(u_.data(), u_.data(), matrix.data());
  fit.covariance = matrix;
  return {};
}

Result<GeometryFit> Bundle::Fit() {
  GeometryFit fit;
  // First without distortion and robustly, to see which views belong together.
  for (bool robust = true;; robust = false) {
    if (auto counts = CheckCounts(); !counts) return counts.error();
    if (auto solved = Solve(robust); !solved) return solved.error();
    if (!LeaveOut() && !robust) break;
  }
  // Each pass: weights by the residuals, the solution, its covariance.
  for (const bool straight : {false, true}) {
    straight_ = straight;
    if (straight) u_[kRadialDistortion] = 0;
    for (int pass = 0; pass < 3; ++pass) {
      Reweigh();
      if (auto solved = Solve(false); !solved) return solved.error();
    }
    ceres::Problem problem;
    Add(problem, false);
    if (auto added = AddCovariance(problem, fit); !added) return added.error();
    const double sigma = std::sqrt(fit.covariance(kRadialDistortion, kRadialDistortion));
    fit.distorted = !straight && std::abs(u_[kRadialDistortion]) > 2 * sigma;
    if (fit.distorted) break;
  }
  for (int i = 0; i < kGeometryUnknowns; ++i) {
    fit.unknowns[i] = {u_[i], std::sqrt(std::max(fit.covariance(i, i), 0.0))};
  }
  fit.has_light = has_light();
  fit.board_rms = board_sigma_;
  fit.mirror_rms = has_light() ? mirror_sigma_ : 0;
  fit.board_views = static_cast<int>(used_boards_.size());
  fit.mirror_views = static_cast<int>(used_mirrors_.size());
  fit.left_out = left_out_;
  return fit;
}

}  // namespace

const char* const kGeometryNames[kGeometryUnknowns] = {"focal_length_px",
                                                       "principal_x_px",
                                                       "principal_y_px",
                                                       "radial_distortion",
                                                       "camera_turn_x_rad",
                                                       "camera_turn_y_rad",
                                                       "camera_turn_z_rad",
                                                       "camera_azimuth_offset_rad",
                                                       "camera_elevation_offset_rad",
                                                       "camera_distance_m",
                                                       "board_tilt_x_rad",
                                                       "board_tilt_y_rad",
                                                       "board_x_m",
                                                       "board_y_m",
                                                       "board_z_m",
                                                       "light_azimuth_offset_rad",
                                                       "light_elevation_offset_rad",
                                                       "light_distance_m",
                                                       "mirror_tilt_x_rad",
                                                       "mirror_tilt_y_rad",
                                                       "mirror_z_m"};

double GeometryFit::SigmaOfDirections(const ArmAngles& arms) const {
  const auto sigma = [&](int unknown, double scale) { return unknowns[unknown].sigma * scale; };
  const double camera = std::max(sigma(kCameraAzimuthOffset, std::cos(arms[kCameraElevation])),
                                 sigma(kCameraElevationOffset, 1));
  const double light = std::max(sigma(kLightAzimuthOffset, std::cos(arms[kLightElevation])),
                                sigma(kLightElevationOffset, 1));
  return std::max(camera, light);
}

std::vector<Eigen::Vector2d> ProjectCorners(const GeometryValues& values,
                                            const GeometryBelief& belief, const Checkerboard& board,
                                            const ArmAngles& arms) {
  const double* u = values.data();
  std::vector<Eigen::Vector2d> corners;
  for (int i = 0; i < board.corners(); ++i) {
    const Eigen::Vector2d corner = board.Corner(i % board.columns, i / board.columns);
    corners.push_back(Project<double>(u, arms, SensorOf(belief), OnBoard(u, corner)));
  }
  return corners;
}

Eigen::Vector2d ProjectHighlight(const GeometryValues& values, const GeometryBelief& belief,
                                 const ArmAngles& arms) {
  const double* u = values.data();
  return Project<double>(u, arms, SensorOf(belief), MirroredLight(u, arms));
}

std::vector<Eigen::Vector2d> PredictCorners(const GeometryBelief& belief, const Checkerboard& board,
                                            const ArmAngles& arms) {
  return ProjectCorners(Believed(belief.imaging), belief, board, arms);
}

Eigen::Vector2d PredictHighlight(const GeometryBelief& belief, const ArmAngles& arms) {
  return ProjectHighlight(Believed(belief.imaging), belief, arms);
}

Result<GeometryFit> FitGeometry(const GeometryBelief& belief, const Checkerboard& board,
                                const std::vector<BoardView>& boards,
                                const std::vector<MirrorView>& mirrors) {
  return Bundle(belief, board, boards, mirrors).Fit();
}

}  // namespace gonio
