// SPDX-License-Identifier: Apache-2.0
// Fit files of models that were fitted slice by slice, and of either kind.

#include <fmt/format.h>

#include <algorithm>
#include <functional>
#include <iterator>

#include "core/config.h"
#include "core/error.h"
#include "core/file.h"
#include "core/units.h"
#include "fitting/hemi_epd.h"
#include "fitting/parameter_file.h"
#include "fitting/table_fit.h"

namespace gonio {
namespace {

Eigen::VectorXd Gather(const std::vector<FittedSlice>& slices, double Lobe::*quantity) {
  std::vector<double> numbers;
  for (const FittedSlice& slice : slices) {
    for (const Lobe& lobe : slice.lobes) numbers.push_back(lobe.*quantity);
  }
  return Eigen::Map<const Eigen::VectorXd>(numbers.data(), Eigen::Index(numbers.size()));
}

void WriteChannel(std::ostream& out, const SlicedDsbrdf& fit, int channel) {
  const std::vector<FittedSlice>& slices = fit.slices(channel);
  if (slices.empty()) return;
  Eigen::VectorXd theta_d_deg(Eigen::Index(slices.size()));
  for (Eigen::Index i = 0; i < theta_d_deg.size(); ++i) {
    theta_d_deg[i] = DegFromRad(slices[i].theta_d);
  }
  out << kChannelNames[channel] << ":\n  ";
  WriteNumbers(out, "theta_d_deg", theta_d_deg);
  out << "  ";
  WriteNumbers(out, "kappa", Gather(slices, &Lobe::kappa));
  out << "  ";
  WriteNumbers(out, "gamma", Gather(slices, &Lobe::gamma));
}

void WriteReport(std::ostream& out, const SliceReport& report) {
  out << fmt::format(
      "  - {{colour: {}, theta_d_deg: {}, points: {}, iterations: {}, converged: {}, cost: {}, "
      "reason: \"{}\"}}\n",
      kChannelNames[report.channel], DegFromRad(report.theta_d), report.points, report.iterations,
      report.converged, report.cost, report.reason);
}

std::vector<FittedSlice> ReadChannel(const ConfigNode& node, int lobes) {
  const std::vector<double> theta_d = node.Numbers("theta_d_deg", 0, Range::Between(0, 90));
  if (std::adjacent_find(theta_d.begin(), theta_d.end(), std::greater_equal<>()) != theta_d.end()) {
    node.Fail("theta_d_deg", "must ascend");
  }
  const std::size_t count = theta_d.size() * lobes;
  const std::vector<double> kappa = node.Numbers("kappa", count, Range::Positive());
  const std::vector<double> gamma = node.Numbers("gamma", count, Range::Positive());
  std::vector<FittedSlice> slices;
  for (std::size_t i = 0; i < theta_d.size(); ++i) {
    FittedSlice slice{.theta_d = RadFromDeg(theta_d[i]), .lobes = {}};
    for (std::size_t k = 0; k < static_cast<std::size_t>(lobes); ++k) {
      slice.lobes.push_back({kappa[i * lobes + k], gamma[i * lobes + k]});
    }
    slices.push_back(std::move(slice));
  }
  return slices;
}

SliceReport ReadReport(const ConfigNode& node) {
  SliceReport report;
  const std::string colour =
      node.Choice("colour", {std::begin(kChannelNames), std::end(kChannelNames)});
  report.channel = static_cast<int>(
      std::find(std::begin(kChannelNames), std::end(kChannelNames), colour) - kChannelNames);
  report.theta_d = RadFromDeg(node.Number("theta_d_deg", Range::Between(0, 90)));
  report.points = node.Integer("points", 0);
  report.iterations = node.Integer("iterations", 0);
  report.converged = node.BoolOr("converged", false);
  report.cost = node.Number("cost");
  report.reason = node.Text("reason");
  return report;
}

SlicedDsbrdf ReadSlices(const ConfigNode& root, SliceMethod method) {
  const int lobes = root.Integer("lobes", 1, kMaxLobes);
  std::array<std::vector<FittedSlice>, kChannels> slices;
  for (int c = 0; c < kChannels; ++c) {
    if (root.Has(kChannelNames[c])) slices[c] = ReadChannel(root.Map(kChannelNames[c]), lobes);
  }
  std::vector<SliceReport> reports;
  if (root.Has("reports")) {
    for (const ConfigNode& node : root.MapList("reports")) reports.push_back(ReadReport(node));
  }
  root.RefuseUnknownKeys();
  return SlicedDsbrdf(method, std::move(slices), std::move(reports),
                      std::filesystem::path(root.file()).filename().string());
}

}  // namespace

void WriteFit(const std::filesystem::path& path, const SlicedDsbrdf& fit) {
  WriteFileAtomically(path, [&](std::ostream& out) {
    out << fmt::format(
        "# A DSBRDF fitted slice by slice: kappa and gamma of each lobe at each theta_d, in the "
        "order\n"
        "# slice, lobe.\n"
        "format: gonio-fit\nversion: 2\nmethod: {}\nlobes: {}\n",
        NameOf(fit.method()), fit.lobes());
    for (int c = 0; c < kChannels; ++c) WriteChannel(out, fit, c);
    if (!fit.reports().empty()) out << "reports:\n";
    for (const SliceReport& report : fit.reports()) WriteReport(out, report);
  });
}

void WriteFit(const std::filesystem::path& path, const LobeModel& model) {
  if (const auto* sliced = dynamic_cast<const SlicedDsbrdf*>(&model))
    return WriteFit(path, *sliced);
  if (const auto* fit = dynamic_cast<const DsbrdfFit*>(&model)) return WriteFit(path, *fit);
  GONIO_CHECK(false, "a model that was fitted");
}

std::unique_ptr<LobeModel> ReadAnyFit(const std::filesystem::path& path) {
  const ConfigNode root = ConfigNode::Load(path);
  root.Choice("format", {"gonio-fit"});
  if (root.Integer("version", 1, kFitFileVersion) == 1) {
    return std::make_unique<DsbrdfFit>(ReadFit(path));
  }
  const std::string method = root.Choice("method", {"em", "joint", "continuous"});
  if (method == "continuous") return std::make_unique<DsbrdfFit>(ReadFit(path));
  return std::make_unique<SlicedDsbrdf>(
      ReadSlices(root, method == "em" ? SliceMethod::kEm : SliceMethod::kJoint));
}

}  // namespace gonio
