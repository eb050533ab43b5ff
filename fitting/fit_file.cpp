// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <Eigen/Cholesky>

#include "core/config.h"
#include "core/file.h"
#include "fitting/fit.h"
#include "fitting/parameter_file.h"

namespace gonio {

void WriteFit(const std::filesystem::path& path, const DsbrdfFit& fit) {
  const FitSummary& summary = fit.summary();
  const DsbrdfShape& shape = fit.model().shape();
  WriteFileAtomically(path, [&](std::ostream& out) {
    out << fmt::format(
        "# A continuous DSBRDF: log kappa and log gamma of each lobe as cubic B-splines over\n"
        "# theta_d; parameter order: channel, lobe, kappa then gamma, knot.\n"
        "format: gonio-fit\nversion: {}\nmethod: continuous\nlobes: {}\nknots: {}\n",
        kFitFileVersion, shape.lobes, shape.knots);
    out << fmt::format(
        "summary:\n  converged: {}\n  reason: {}\n  samples: {}\n  residuals: {}\n"
        "  iterations: {}\n  starts: {}\n  cost: {}\n  model_error: {}\n  floor_per_sr: {}\n",
        summary.converged, summary.reason, summary.samples, summary.residuals, summary.iterations,
        summary.starts, summary.cost, summary.model_error, summary.floor);
    WriteNumbers(out, "parameters", fit.model().parameters());
    WriteNumbers(out, "covariance_lower", LowerOf(fit.covariance()));
  });
}

DsbrdfFit ReadFit(const std::filesystem::path& path) {
  const ConfigNode root = ConfigNode::Load(path);
  root.Choice("format", {"gonio-fit"});
  if (root.Integer("version", 1, kFitFileVersion) > 1) root.Choice("method", {"continuous"});
  DsbrdfShape shape;
  shape.lobes = root.Integer("lobes", 1, kMaxLobes);
  shape.knots = root.Integer("knots", kMinKnots, kMaxKnots);
  const ConfigNode node = root.Map("summary");
  FitSummary summary;
  summary.converged = node.BoolOr("converged", false);
  summary.reason = node.Text("reason");
  summary.samples = node.Integer("samples", 0);
  summary.residuals = node.Integer("residuals", 0);
  summary.iterations = node.Integer("iterations", 0);
  summary.starts = node.Integer("starts", 0);
  summary.cost = node.Number("cost");
  summary.model_error = node.Number("model_error", Range::NonNegative());
  summary.floor = node.Number("floor_per_sr", Range::Positive());
  const auto size = static_cast<std::size_t>(shape.size());
  const std::vector<double> parameters = root.Numbers("parameters", size);
  const std::vector<double> lower = root.Numbers("covariance_lower", size * (size + 1) / 2);
  root.RefuseUnknownKeys();
  Eigen::MatrixXd covariance = SymmetricFromLower(lower, shape.size());
  if (covariance.llt().info() != Eigen::Success) {
    root.Fail("covariance_lower", "is not positive definite");
  }
  return DsbrdfFit(Dsbrdf(shape, Eigen::Map<const Eigen::VectorXd>(parameters.data(), shape.size()),
                          path.filename().string()),
                   std::move(covariance), std::move(summary));
}

}  // namespace gonio
