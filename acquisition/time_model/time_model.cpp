// SPDX-License-Identifier: Apache-2.0
#include "acquisition/time_model/time_model.h"

#include <ceres/ceres.h>
#include <fmt/format.h>
#include <fmt/ostream.h>

#include <algorithm>
#include <cmath>

#include "acquisition/light_colours.h"
#include "acquisition/radiometry/calibration_file.h"
#include "core/config.h"
#include "core/file.h"
#include "core/units.h"
#include "core/utc.h"
#include "drivers/move_time.h"

namespace gonio {
namespace {

// Of each axis: logarithms of speed and acceleration, and the overhead.
constexpr int kPerAxis = 3;
constexpr int kUnknowns = kPerAxis * kAxes;
// How far the rig file is believed to be right: of the logarithms, and s.
constexpr double kBelief = 0.5;
// s; no clock of a session is better than that.
constexpr double kLeastSigma = 1e-3;

// As drivers/move_time.h has it for one axis without approach.
template <typename T>
T AxisTime(double way, const T* u) {
  using std::exp, std::sqrt;
  const T speed = exp(u[0]);
  const T acceleration = exp(u[1]);
  const T distance(std::abs(way));
  if (distance < speed * speed / acceleration) return T(2) * sqrt(distance / acceleration) + u[2];
  return distance / speed + speed / acceleration + u[2];
}

// The axis that decides is taken at the point where the derivative is asked for.
template <typename T>
T TimeOf(const LoggedMove& move, const std::array<double, kAxes>& tolerances, const T* u,
         int* slowest = nullptr) {
  T longest(0);
  for (int i = 0; i < kAxes; ++i) {
    if (std::abs(move.way[i]) <= tolerances[i]) continue;
    const T time = AxisTime(move.way[i], u + kPerAxis * i);
    if (!(time > longest)) continue;
    longest = time;
    if (slowest) *slowest = i;
  }
  return longest;
}

struct MoveResidual {
  LoggedMove move;
  std::array<double, kAxes> tolerances;
  double sigma;
  template <typename T>
  bool operator()(const T* u, T* residual) const {
    residual[0] = (TimeOf(move, tolerances, u) - move.time.count()) / sigma;
    return true;
  }
};

struct Belief {
  std::array<double, kUnknowns> believed;
  template <typename T>
  bool operator()(const T* u, T* residual) const {
    for (int i = 0; i < kUnknowns; ++i) residual[i] = (u[i] - believed[i]) / kBelief;
    return true;
  }
};

std::array<double, kUnknowns> Believed(const RigConfig& rig) {
  std::array<double, kUnknowns> u{};
  for (int i = 0; i < rig.axis_count; ++i) {  // the rest never moves, and stays at 0
    u[kPerAxis * i] = std::log(rig.axes[i].max_speed);
    u[kPerAxis * i + 1] = std::log(rig.axes[i].acceleration);
    u[kPerAxis * i + 2] = rig.axes[i].move_overhead.count();
  }
  return u;
}

class Fitter {
 public:
  Fitter(const RigConfig& rig, const std::vector<LoggedMove>& moves)
      : moves_(moves), believed_(Believed(rig)), u_(believed_) {
    for (int i = 0; i < kAxes; ++i) tolerances_[i] = rig.axes[i].position_tolerance;
  }

  double Rms() const {
    double sum = 0;
    for (const LoggedMove& move : moves_) {
      sum += std::pow(TimeOf(move, tolerances_, u_.data()) - move.time.count(), 2);
    }
    return std::sqrt(sum / static_cast<double>(moves_.size()));
  }

  Result<void> Solve(TimeFit& fit) {
    for (const double sigma : {0.1, 0.0, 0.0}) {
      const double used = sigma > 0 ? sigma : std::max(Rms(), kLeastSigma);
      ceres::Problem problem;
      Add(problem, used);
      ceres::Solver::Options options;
      options.linear_solver_type = ceres::DENSE_QR;
      options.max_num_iterations = 200;
      options.logging_type = ceres::SILENT;
      ceres::Solver::Summary summary;
      ceres::Solve(options, &problem, &summary);
      if (!summary.IsSolutionUsable()) {
        return Error{ErrorCode::kRefused, "the moves fit no axes: " + summary.message};
      }
      if (auto told = Tell(problem, fit); !told) return told;
    }
    return {};
  }

 private:
  void Add(ceres::Problem& problem, double sigma) {
    for (const LoggedMove& move : moves_) {
      problem.AddResidualBlock(new ceres::AutoDiffCostFunction<MoveResidual, 1, kUnknowns>(
                                   new MoveResidual{move, tolerances_, sigma}),
                               new ceres::HuberLoss(4), u_.data());
    }
    problem.AddResidualBlock(
        new ceres::AutoDiffCostFunction<Belief, kUnknowns, kUnknowns>(new Belief{believed_}),
        nullptr, u_.data());
    for (int i = 0; i < kAxes; ++i) problem.SetParameterLowerBound(u_.data(), kPerAxis * i + 2, 0);
  }

  Result<void> Tell(ceres::Problem& problem, TimeFit& fit) {
    ceres::Covariance covariance({});
    const std::vector<std::pair<const double*, const double*>> blocks = {{u_.data(), u_.data()}};
    if (!covariance.Compute(blocks, &problem)) {
      return Error{ErrorCode::kRefused, "the moves leave the axes open"};
    }
    std::array<double, kUnknowns * kUnknowns> matrix{};
    covariance.GetCovarianceBlock(u_.data(), u_.data(), matrix.data());
    const auto sigma = [&](int i) { return std::sqrt(matrix[i * kUnknowns + i]); };
    for (int i = 0; i < kAxes; ++i) {
      const int at = kPerAxis * i;
      fit.max_speed[i] = {std::exp(u_[at]), std::exp(u_[at]) * sigma(at)};
      fit.acceleration[i] = {std::exp(u_[at + 1]), std::exp(u_[at + 1]) * sigma(at + 1)};
      fit.move_overhead[i] = {u_[at + 2], sigma(at + 2)};
    }
    fit.decided = {};
    for (const LoggedMove& move : moves_) {
      int slowest = -1;
      TimeOf(move, tolerances_, u_.data(), &slowest);
      if (slowest >= 0) ++fit.decided[slowest];
    }
    return {};
  }

  const std::vector<LoggedMove>& moves_;
  const std::array<double, kUnknowns> believed_;
  std::array<double, kUnknowns> u_;
  std::array<double, kAxes> tolerances_{};
};

// spare = pose_overhead + frames frame_overhead. With the same number of frames everywhere the two
// are not told apart, and all of it is the pose's.
void FitSpare(const std::vector<LoggedPose>& poses, TimeFit& fit) {
  std::vector<double> frames;
  std::vector<double> spare;
  for (const LoggedPose& pose : poses) {
    frames.push_back(pose.frames);
    spare.push_back(pose.spare.count());
  }
  std::vector<double> sigmas(poses.size(), 1);
  if (const auto line = FitLine(frames, spare, sigmas)) {
    const double rms =
        std::max(std::sqrt(line->chi_squared / std::max(line->degrees_of_freedom, 1)), kLeastSigma);
    fit.pose_overhead = {std::max(line->intercept.value, 0.0), line->intercept.sigma * rms};
    fit.frame_overhead = {std::max(line->slope.value, 0.0), line->slope.sigma * rms};
    return;
  }
  double sum = 0;
  for (const double s : spare) sum += s;
  if (!spare.empty()) fit.pose_overhead = {std::max(sum / spare.size(), 0.0), kLeastSigma};
}

}  // namespace

void AddTimes(const SessionRecord& session, const RigConfig& rig, LoggedTimes& times) {
  const MeasuredPose* last = nullptr;
  for (const MeasuredPose& pose : session.poses) {
    if (pose.move_retries == 0) {
      times.poses.push_back(
          {pose.frames, pose.end - pose.start - pose.move_time - rig.motion.settle - pose.exposed -
                            pose.frames * rig.camera.readout - ColourChangesOf(rig)});
    }
    const bool direct =
        last && pose.move_retries == 0 &&
        std::none_of(session.events.begin(), session.events.end(), [&](const SessionEvent& e) {
          return e.kind == "pose_rejected" && e.time > last->end && e.time <= pose.start;
        });
    if (direct) {
      LoggedMove move{.time = pose.move_time};
      for (int i = 0; i < kAxes; ++i) move.way[i] = pose.commanded[i] - last->readback[i];
      times.moves.push_back(move);
    }
    last = &pose;
  }
}

TimeModel TimeFit::Model() const {
  TimeModel model;
  for (int i = 0; i < kAxes; ++i) {
    model.max_speed[i] = max_speed[i].value;
    model.acceleration[i] = acceleration[i].value;
    model.move_overhead[i] = Seconds(move_overhead[i].value);
  }
  model.pose_overhead = Seconds(pose_overhead.value);
  model.frame_overhead = Seconds(frame_overhead.value);
  return model;
}

Result<TimeFit> FitTimes(const RigConfig& rig, const LoggedTimes& times) {
  TimeFit fit;
  fit.moves = static_cast<int>(times.moves.size());
  if (fit.moves < kLeastMoves) {
    return Error{ErrorCode::kRefused, fmt::format("the sessions have {} moves whose beginning is "
                                                  "known; {} are needed",
                                                  fit.moves, kLeastMoves)};
  }
  Fitter fitter(rig, times.moves);
  fit.believed_rms = fitter.Rms();
  if (auto solved = fitter.Solve(fit); !solved) return solved.error();
  fit.fitted_rms = fitter.Rms();
  FitSpare(times.poses, fit);
  return fit;
}

void WriteTimes(const std::filesystem::path& path, const TimeFit& fit,
                std::span<const char* const> axes, std::int64_t now) {
  WriteFileAtomically(path, [&](std::ostream& out) {
    const auto line = [&](const char* indent, const char* key, const MeasuredValue& e,
                          double unit) {
      fmt::print(out, "{}{}: [{:.9g}, {:.3g}]\n", indent, key, e.value / unit, e.sigma / unit);
    };
    const double degree = RadFromDeg(1);
    fmt::print(out,
               "# Each: value and standard uncertainty.\nversion: 1\nkind: time\n"
               "created_utc: \"{}\"\naxes:\n",
               UtcText(now));
    for (std::size_t i = 0; i < axes.size(); ++i) {
      fmt::print(out, "  {}:  # the slowest in {} moves\n", axes[i], fit.decided[i]);
      line("    ", "max_speed_deg_s", fit.max_speed[i], degree);
      line("    ", "acceleration_deg_s2", fit.acceleration[i], degree);
      line("    ", "move_overhead_s", fit.move_overhead[i], 1);
    }
    line("", "pose_overhead_s", fit.pose_overhead, 1);
    line("", "frame_overhead_s", fit.frame_overhead, 1);
    fmt::print(out, "moves: {}\nrms_s: {:.6g}\nbelieved_rms_s: {:.6g}\n", fit.moves, fit.fitted_rms,
               fit.believed_rms);
  });
}

TimeModel ReadTimes(const std::filesystem::path& path, std::span<const char* const> names) {
  const ConfigNode root = ConfigNode::Load(path);
  root.Integer("version", 1, 1);
  root.Choice("kind", {"time"});
  (void)root.Text("created_utc");
  TimeModel model;
  const ConfigNode axes = root.Map("axes");
  for (std::size_t i = 0; i < names.size(); ++i) {
    const ConfigNode axis = axes.Map(names[i]);
    model.max_speed[i] = RadFromDeg(axis.Numbers("max_speed_deg_s", 2, Range::NonNegative())[0]);
    model.acceleration[i] =
        RadFromDeg(axis.Numbers("acceleration_deg_s2", 2, Range::NonNegative())[0]);
    model.move_overhead[i] = Seconds(axis.Numbers("move_overhead_s", 2, Range::NonNegative())[0]);
    if (model.max_speed[i] <= 0) axis.Fail("max_speed_deg_s", "must be > 0");
    if (model.acceleration[i] <= 0) axis.Fail("acceleration_deg_s2", "must be > 0");
  }
  model.pose_overhead = Seconds(root.Numbers("pose_overhead_s", 2, Range::NonNegative())[0]);
  model.frame_overhead = Seconds(root.Numbers("frame_overhead_s", 2, Range::NonNegative())[0]);
  root.Integer("moves", 0);
  root.Number("rms_s", Range::NonNegative());
  root.Number("believed_rms_s", Range::NonNegative());
  root.RefuseUnknownKeys();
  return model;
}

}  // namespace gonio
