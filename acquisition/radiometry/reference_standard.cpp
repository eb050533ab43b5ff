// SPDX-License-Identifier: Apache-2.0
#include "acquisition/radiometry/reference_standard.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/check.h"
#include "core/config.h"
#include "core/units.h"

namespace gonio {
namespace {

double Square(double x) { return x * x; }

Rgb ThreeNumbers(const ConfigNode& node, const char* key, Range range) {
  const std::vector<double> numbers = node.Numbers(key, kChannels, range);
  return {numbers[0], numbers[1], numbers[2]};
}

Error Refusal(const std::string& why) { return {ErrorCode::kRefused, "reference: " + why}; }

}  // namespace

ReferenceStandard ReferenceStandard::Load(const std::filesystem::path& path) {
  const ConfigNode root = ConfigNode::Load(path);
  root.Choice("format", {"gonio-reference-standard"});
  root.Integer("version", 1, 1);
  const double coverage = root.NumberOr("coverage_factor", 1, Range::Positive());
  std::vector<StandardPoint> points;
  for (const ConfigNode& node : root.MapList("points")) {
    StandardPoint point;
    point.theta_i = RadFromDeg(node.Number("theta_i_deg", Range::Between(0, 89.999)));
    point.theta_o = RadFromDeg(node.Number("theta_o_deg", Range::Between(-89.999, 89.999)));
    point.f_r = ThreeNumbers(node, "f_r", Range::Positive());
    point.sigma = ThreeNumbers(node, "f_r_uncertainty", Range::NonNegative()) / coverage;
    points.push_back(point);
  }
  if (points.empty()) root.Fail("points", "must not be empty");
  ReferenceStandard standard(root.Text("name"), std::move(points));
  root.RefuseUnknownKeys();
  return standard;
}

ReferenceStandard::ReferenceStandard(std::string name, std::vector<StandardPoint> points)
    : name_(std::move(name)), points_(std::move(points)) {
  GONIO_CHECK(!points_.empty(), "a standard has points");
}

Result<MeasuredValue> ReferenceStandard::At(double theta_i, double theta_o, int channel,
                                            double tolerance) const {
  const auto distance = [&](const StandardPoint& p) {
    return std::max(std::abs(p.theta_i - theta_i), std::abs(p.theta_o - theta_o));
  };
  const auto nearest =
      std::min_element(points_.begin(), points_.end(),
                       [&](const auto& a, const auto& b) { return distance(a) < distance(b); });
  if (!(distance(*nearest) <= tolerance)) {
    return Refusal(fmt::format("{} is not known at {:.2f}:{:.2f} degrees", name_,
                               DegFromRad(theta_i), DegFromRad(theta_o)));
  }
  return MeasuredValue{nearest->f_r[channel], nearest->sigma[channel]};
}

Result<MeasuredValue> ResponsivityFrom(const MeasuredValue& rate, const MeasuredValue& f_r,
                                       double relative_noise) {
  if (!(f_r.value > 0)) return Refusal("the standard's f_r must be > 0");
  if (!(rate.value > 0)) return Refusal("no signal from the standard");
  const double value = rate.value / f_r.value;
  const double relative =
      std::sqrt(Square(rate.relative()) + Square(f_r.relative()) + Square(relative_noise));
  return MeasuredValue{value, value * relative};
}

JoinedResponsivity JoinResponsivities(const std::vector<MeasuredValue>& independent,
                                      double shared_relative) {
  GONIO_CHECK(!independent.empty(), "something to join");
  double weights = 0;
  double weighted = 0;
  for (const MeasuredValue& e : independent) {
    GONIO_CHECK(e.sigma > 0, "a measurement has an uncertainty");
    weights += 1 / Square(e.sigma);
    weighted += e.value / Square(e.sigma);
  }
  JoinedResponsivity joined;
  joined.responsivity.value = weighted / weights;
  for (const MeasuredValue& e : independent) {
    joined.chi_squared += Square((e.value - joined.responsivity.value) / e.sigma);
  }
  joined.degrees_of_freedom = static_cast<int>(independent.size()) - 1;
  double variance = 1 / weights;
  if (joined.degrees_of_freedom > 0) {
    variance *= std::max(1.0, joined.chi_squared / joined.degrees_of_freedom);
  }
  joined.responsivity.sigma =
      std::sqrt(variance + Square(shared_relative * joined.responsivity.value));
  return joined;
}

}  // namespace gonio
