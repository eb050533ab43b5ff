// SPDX-License-Identifier: Apache-2.0
// Analytic materials: layers of well-known reflectance models, described in YAML.

#pragma once

#include <filesystem>
#include <memory>
#include <string>
#include <variant>
#include <vector>

#include "brdf/brdf.h"

namespace gonio {

// Ideal diffuse: f_r = albedo / pi.
struct Lambert {
  Rgb albedo = Rgb::Constant(0.5);  // 0 .. 1
};

// Rough diffuse: Oren and Nayar, "Generalization of Lambert's Reflectance Model", SIGGRAPH 1994, in
// the form of Y. Fujii, "A tiny improvement of Oren-Nayar reflectance model". It keeps the
// qualitative model's shape, but its albedo never exceeds 1 (theirs does, by up to 2 % at grazing)
// and it has no kink at phi = 90 deg.
struct OrenNayar {
  Rgb albedo = Rgb::Constant(0.5);  // 0 .. 1
  double roughness = 0.5;           // Fujii's sigma, 0 (Lambert) .. 1
};

// Microfacet reflection: GGX normals (Walter et al., EGSR 2007) with height-correlated Smith
// masking (Heitz, JCGT 2014). Single scattering: the rougher, the more light is lost.
struct Ggx {
  double roughness = 0.1;        // alpha_g of Walter et al., not squared again; 0.01 .. 1
  Rgb f0 = Rgb::Constant(0.04);  // ior = 0: Schlick's Fresnel term with this colour at 0 deg
  double ior = 0;                // > 1: the exact Fresnel term of a dielectric; f0 is not used
};

// Retro-reflection (beads, cloth): a GGX lobe about the *back* vector, the half vector of wo and
// wi mirrored at the normal (Belcour et al., "BRDF measurements and analysis of retroreflecting
// materials", JOSA A 31(12), 2014). No Fresnel term.
struct Retro {
  double roughness = 0.3;              // as for Ggx
  Rgb strength = Rgb::Constant(0.05);  // 0 .. 1, reflectance of a bead
};

using Layer = std::variant<Lambert, OrenNayar, Ggx, Retro>;

// A stack of layers, the lowest first. What a layer reflects is the lower ones' loss: a layer with
// directional albedo E dims all below it by (1 - E(theta_i)) (1 - E(theta_o)), which is reciprocal
// and keeps the total albedo <= 1 whatever the layers are (the albedo coupling of Kelemen and
// Szirmay-Kalos, Eurographics 2001, without its multiple bounces). E is tabulated by quadrature.
//
// Reciprocal, isotropic, non-negative, finite wherever both cosines are > 0; energy conserving to
// within 0.5 % (the quadrature). tests/brdf/analytic_test.cpp checks all five.
class AnalyticBrdf final : public Brdf {
 public:
  // Takes some 10 ms for each layer above the lowest. Preconditions: at least one layer, values as
  // stated above.
  AnalyticBrdf(std::string name, std::vector<Layer> layers);

  std::optional<Rgb> Eval(const HalfDiff& angles) const override;
  using Brdf::Eval;

  std::string name() const override { return name_; }

 private:
  // 1 - E over a grid of sqrt(cosine), for the light that passes a layer.
  using Transmission = std::vector<Rgb>;

  std::string name_;
  std::vector<Layer> layers_;
  std::vector<Transmission> through_;  // [i]: of layer i; [0] is empty, nothing lies below
};

// Reads a material such as
//
//   version: 1
//   name: satin paint
//   layers:                        # the lowest first
//     - kind: oren_nayar           # albedo, roughness
//       albedo: [0.1, 0.3, 0.25]
//       roughness: 0.4
//     - kind: ggx                  # roughness, and either f0: [r, g, b] or ior
//       roughness: 0.15
//       ior: 1.5
//
// The other kinds are lambert (albedo) and retro (roughness, strength). Every key is required,
// ranges are those of the structs above. Throws ConfigError "FILE:LINE: KEY: ...".
std::unique_ptr<Brdf> LoadMaterial(const std::filesystem::path& path);
// `name` stands for the file in messages.
std::unique_ptr<Brdf> ParseMaterial(const std::string& text, const std::string& name);

}  // namespace gonio
