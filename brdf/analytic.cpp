// SPDX-License-Identifier: Apache-2.0
#include "brdf/analytic.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/check.h"
#include "core/units.h"

namespace gonio {
namespace {

// What the models need to know about a pair, from its half/difference angles in six trigonometric
// calls and without cancellation near the lobes' axes.
struct Geometry {
  explicit Geometry(const HalfDiff& angles) {
    const double sin_h = std::sin(angles.theta_h), sin_d = std::sin(angles.theta_d);
    const double cos_p = std::cos(angles.phi_d), cos_h = std::cos(angles.theta_h);
    cos_d = std::cos(angles.theta_d);
    cos_i = cos_d * cos_h - sin_d * cos_p * sin_h;
    cos_o = cos_d * cos_h + sin_d * cos_p * sin_h;
    tangents = (cos_d - sin_d) * (cos_d + sin_d) - cos_i * cos_o;
    half_cos2 = cos_h * cos_h;
    half_sin2 = sin_h * sin_h;
    // Both components of mirrored wi + wo, halved and squared; see Retro.
    const double along = cos_d * cos_h, across = cos_p * sin_h;
    const double back_z2 = along * along;
    const double back_xy2 = sin_d * sin_d * (1 - across * across);
    back_cos2 = back_z2 / (back_z2 + back_xy2);
    back_sin2 = back_xy2 / (back_z2 + back_xy2);
  }

  double cos_i, cos_o, cos_d;
  double tangents;              // dot product of the tangential parts of wi and wo
  double half_cos2, half_sin2;  // of the half vector's polar angle
  double back_cos2, back_sin2;  // of the back vector's polar angle
};

// D G / (4 cos_i cos_o) of GGX: the normals' distribution times what masking leaves. `cos2` and
// `sin2` are of the lobe's vector, half or back.
double GgxLobe(double roughness, double cos2, double sin2, double cos_i, double cos_o) {
  const double a2 = roughness * roughness;
  const double spread = a2 * cos2 + sin2;
  const double distribution = a2 / (kPi * spread * spread);
  const auto shadow = [a2](double c) { return std::sqrt(a2 + (1 - a2) * c * c); };
  return distribution * 0.5 / (cos_o * shadow(cos_i) + cos_i * shadow(cos_o));
}

double DielectricFresnel(double ior, double cos_d) {
  const double inside = std::sqrt(ior * ior - 1 + cos_d * cos_d);  // ior times the refracted cosine
  const double s = (cos_d - inside) / (cos_d + inside);
  const double p = (ior * ior * cos_d - inside) / (ior * ior * cos_d + inside);
  return 0.5 * (s * s + p * p);
}

Rgb Fresnel(const Ggx& layer, double cos_d) {
  if (layer.ior > 0) return Rgb::Constant(DielectricFresnel(layer.ior, cos_d));
  const double x = 1 - cos_d;
  return layer.f0 + (1 - layer.f0) * (x * x * x * x * x);
}

Rgb EvalLayer(const Lambert& layer, const Geometry&) { return layer.albedo / kPi; }

Rgb EvalLayer(const OrenNayar& layer, const Geometry& g) {
  const double scale = 1 / (kPi + (kPi / 2 - 2.0 / 3) * layer.roughness);
  const double s = g.tangents;
  const double t = s > 0 ? std::max(g.cos_i, g.cos_o) : 1;
  return layer.albedo * (scale * (1 + layer.roughness * std::max(s, -1.0) / t));
}

Rgb EvalLayer(const Ggx& layer, const Geometry& g) {
  return Fresnel(layer, g.cos_d) *
         GgxLobe(layer.roughness, g.half_cos2, g.half_sin2, g.cos_i, g.cos_o);
}

Rgb EvalLayer(const Retro& layer, const Geometry& g) {
  return layer.strength * GgxLobe(layer.roughness, g.back_cos2, g.back_sin2, g.cos_i, g.cos_o);
}

Rgb EvalLayer(const Layer& layer, const Geometry& g) {
  return std::visit([&g](const auto& model) { return EvalLayer(model, g); }, layer);
}

// The quadrature of directional albedos: strata over the azimuth and over the share of light (or
// of microfacet normals) within a polar angle.
constexpr int kAzimuths = 48;
constexpr int kPolars = 48;

template <typename Term>
Rgb MeanOverStrata(const Term& term) {
  Rgb sum = Rgb::Zero();
  for (int i = 0; i < kPolars; ++i) {
    for (int j = 0; j < kAzimuths; ++j) {
      sum += term((i + 0.5) / kPolars, 2 * kPi * (j + 0.5) / kAzimuths);
    }
  }
  return sum / (kPolars * kAzimuths);
}

// Directional albedo at wi of a layer without a narrow lobe: cosine-distributed wo.
template <typename Model>
Rgb Albedo(const Model& layer, const Eigen::Vector3d& wi) {
  return MeanOverStrata([&](double share, double phi) -> Rgb {
    const Eigen::Vector3d wo = FromSpherical(std::asin(std::sqrt(share)), phi);
    return kPi * EvalLayer(layer, Geometry(ToHalfDiff({wi, wo})));
  });
}

// The same for a GGX lobe, times `factor` of the cosine at the microfacet: normals
// distributed as the facets' projected areas, so that narrow lobes are met as well as wide ones.
template <typename Factor>
Rgb LobeAlbedo(double roughness, const Eigen::Vector3d& wi, const Factor& factor) {
  return MeanOverStrata([&](double share, double phi) -> Rgb {
    const double tangent = roughness * std::sqrt(share / (1 - share));
    const Eigen::Vector3d h = FromSpherical(std::atan(tangent), phi);
    const double cos_d = h.dot(wi);
    const Eigen::Vector3d wo = 2 * cos_d * h - wi;
    if (cos_d <= 0 || wo.z() <= 0) return Rgb::Zero();
    const double a2 = roughness * roughness;
    const auto shadow = [a2](double c) { return std::sqrt(a2 + (1 - a2) * c * c); };
    const double visible = 2 * wo.z() / (wo.z() * shadow(wi.z()) + wi.z() * shadow(wo.z()));
    return factor(cos_d) * (visible * cos_d / h.z());
  });
}

Rgb Albedo(const Ggx& layer, const Eigen::Vector3d& wi) {
  return LobeAlbedo(layer.roughness, wi, [&](double cos_d) { return Fresnel(layer, cos_d); });
}

// Mirroring wi turns the retro lobe into a plain one, and changes no albedo.
Rgb Albedo(const Retro& layer, const Eigen::Vector3d& wi) {
  return LobeAlbedo(layer.roughness, wi, [&](double) { return layer.strength; });
}

// Grid of transmissions: node k lies at cosine (k / kNodes)^2, dense at grazing, where Fresnel and
// masking bend most.
constexpr int kNodes = 64;

std::vector<Rgb> Transmissions(const Layer& layer) {
  std::vector<Rgb> nodes;
  for (int k = 0; k <= kNodes; ++k) {
    const double root = std::max(k, 1) / double{kNodes};
    const double cosine = k == 0 ? 1e-6 : root * root;
    const Eigen::Vector3d wi(std::sqrt(1 - cosine * cosine), 0, cosine);
    const Rgb albedo = std::visit([&](const auto& model) { return Albedo(model, wi); }, layer);
    nodes.push_back((1 - albedo).max(0));
  }
  return nodes;
}

Rgb Interpolate(const std::vector<Rgb>& nodes, double cosine) {
  const double position = std::sqrt(std::min(cosine, 1.0)) * kNodes;
  const int low = std::min(static_cast<int>(position), kNodes - 1);
  const double weight = position - low;
  return (1 - weight) * nodes[low] + weight * nodes[low + 1];
}

}  // namespace

AnalyticBrdf::AnalyticBrdf(std::string name, std::vector<Layer> layers)
    : name_(std::move(name)), layers_(std::move(layers)) {
  GONIO_CHECK(!layers_.empty(), name_);
  through_.resize(layers_.size());
  for (std::size_t i = 1; i < layers_.size(); ++i) through_[i] = Transmissions(layers_[i]);
}

std::optional<Rgb> AnalyticBrdf::Eval(const HalfDiff& angles) const {
  const Geometry g(angles);
  if (!(g.cos_i > 0 && g.cos_o > 0)) return std::nullopt;
  Rgb f_r = EvalLayer(layers_[0], g);
  for (std::size_t i = 1; i < layers_.size(); ++i) {
    f_r *= Interpolate(through_[i], g.cos_i) * Interpolate(through_[i], g.cos_o);
    f_r += EvalLayer(layers_[i], g);
  }
  return f_r;
}

}  // namespace gonio
