// SPDX-License-Identifier: Apache-2.0
#include "fitting/prior.h"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "core/config.h"
#include "core/error.h"
#include "core/file.h"
#include "core/units.h"
#include "fitting/parameter_file.h"
#include "fitting/process_file.h"
#include "fitting/spline.h"

namespace gonio {
namespace {

// What the generic prior believes of one quantity (log kappa or log gamma) of one lobe. Spreads are
// standard deviations in natural logarithms.
struct Belief {
  double mean;
  double level;          // of the level all channels and theta_d share
  double channel_level;  // of one channel against the others
  double shape;          // of the smooth course over theta_d, shared by the channels
  double channel_shape;  // of one channel's own course
};

struct LobeBelief {
  Belief log_kappa;
  Belief log_gamma;
};

constexpr double kCourseLength = RadFromDeg(15);  // over which the course in theta_d varies

// Lobe k of K: from a diffuse one (cos^0.5, f_r about 0.1 / sr) to a narrow one (half width about 5
// degrees), geometrically spaced in gamma.
LobeBelief BeliefOf(int lobe, int lobes) {
  const double position = lobes == 1 ? 0.5 : static_cast<double>(lobe) / (lobes - 1);
  const double log_gamma = std::log(0.5) + position * (std::log(200.0) - std::log(0.5));
  const bool diffuse = lobe == 0;
  LobeBelief belief;
  belief.log_kappa = {diffuse ? std::log(0.1) : std::log(0.5), 2.0, diffuse ? 1.4 : 0.8, 1.0, 0.5};
  belief.log_gamma = {log_gamma, diffuse ? 1.2 : 1.5, 0.4, 1.0, 0.4};
  return belief;
}

// Covariance of one quantity at two knots `distance` [rad] apart, of the same channel or of two.
double CovarianceOf(const Belief& belief, double distance, bool same_channel) {
  const double course = std::exp(-0.5 * distance * distance / (kCourseLength * kCourseLength));
  double covariance = belief.level * belief.level + belief.shape * belief.shape * course;
  if (same_channel) {
    covariance += belief.channel_level * belief.channel_level +
                  belief.channel_shape * belief.channel_shape * course;
    if (distance == 0) covariance += 1e-4;  // keeps the matrix well conditioned
  }
  return covariance;
}

// The same between all knots.
Eigen::MatrixXd CourseCovariance(const Belief& belief, int knots, bool same_channel) {
  Eigen::MatrixXd covariance(knots, knots);
  for (int i = 0; i < knots; ++i) {
    for (int j = 0; j < knots; ++j) {
      covariance(i, j) =
          CovarianceOf(belief, KnotPosition(i, knots) - KnotPosition(j, knots), same_channel);
    }
  }
  return covariance;
}

}  // namespace

bool HasSeen(const Prior& prior, const std::string& material) {
  return std::find(prior.materials.begin(), prior.materials.end(), material) !=
         prior.materials.end();
}

Prior GenericPrior(const DsbrdfShape& shape) {
  CheckShape(shape);
  Prior prior{.name = "generic",
              .shape = shape,
              .mean = {},
              .covariance = {},
              .materials = {},
              .process = nullptr};
  prior.mean.resize(shape.size());
  prior.covariance.setZero(shape.size(), shape.size());
  for (int k = 0; k < shape.lobes; ++k) {
    const LobeBelief lobe = BeliefOf(k, shape.lobes);
    for (int a = 0; a < kChannels; ++a) {
      for (int q = 0; q < 2; ++q) {
        const Belief& belief = q == 0 ? lobe.log_kappa : lobe.log_gamma;
        prior.mean.segment(shape.Index(a, k, q), shape.knots).setConstant(belief.mean);
        for (int b = 0; b < kChannels; ++b) {
          prior.covariance.block(shape.Index(a, k, q), shape.Index(b, k, q), shape.knots,
                                 shape.knots) = CourseCovariance(belief, shape.knots, a == b);
        }
      }
    }
  }
  return prior;
}

Prior NoPrior(const DsbrdfShape& shape) {
  Prior prior = GenericPrior(shape);
  prior.name = "none";
  prior.covariance *= kUnbelief * kUnbelief;
  return prior;
}

Prior ReadPrior(const std::filesystem::path& path) {
  const ConfigNode root = ConfigNode::Load(path);
  root.Choice("format", {"gonio-prior"});
  root.Integer("version", 1, 1);
  Prior prior;
  prior.name = root.Text("name");
  prior.shape.lobes = root.Integer("lobes", 1, kMaxLobes);
  prior.shape.knots = root.Integer("knots", kMinKnots, kMaxKnots);
  prior.materials = root.Texts("materials");
  const auto size = static_cast<std::size_t>(prior.shape.size());
  const std::vector<double> mean = root.Numbers("mean", size);
  const std::vector<double> triangle = root.Numbers("covariance_lower", size * (size + 1) / 2);
  if (root.Has("process")) prior.process = ReadProcess(root.Map("process"));
  root.RefuseUnknownKeys();
  prior.mean = Eigen::Map<const Eigen::VectorXd>(mean.data(), prior.shape.size());
  prior.covariance = SymmetricFromLower(triangle, prior.shape.size());
  if (prior.covariance.llt().info() != Eigen::Success) {
    root.Fail("covariance_lower", "is not positive definite");
  }
  return prior;
}

void WritePrior(const std::filesystem::path& path, const Prior& prior) {
  std::vector<std::string> materials;
  for (const std::string& material : prior.materials) materials.push_back(YamlQuoted(material));
  WriteFileAtomically(path, [&](std::ostream& out) {
    out << fmt::format(
        "format: gonio-prior\nversion: 1\nname: {}\nlobes: {}\nknots: {}\nmaterials: [{}]\n",
        YamlQuoted(prior.name), prior.shape.lobes, prior.shape.knots, fmt::join(materials, ", "));
    WriteNumbers(out, "mean", prior.mean);
    WriteNumbers(out, "covariance_lower", LowerOf(prior.covariance));
    if (prior.process) WriteProcess(out, *prior.process);
  });
}

}  // namespace gonio
