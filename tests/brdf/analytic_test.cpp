// SPDX-License-Identifier: Apache-2.0
#include "brdf/analytic.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <random>

#include "core/units.h"

namespace gonio {
namespace {

const Rgb kWhite = Rgb::Ones();

struct Material {
  const char* label;
  std::vector<Layer> layers;
};

void PrintTo(const Material& material, std::ostream* out) { *out << material.label; }

// Each model alone, at the ends of its ranges, and stacks; white, where energy is tightest.
std::vector<Material> Materials() {
  return {
      {"Lambert", {Lambert{kWhite}}},
      {"OrenNayarSmooth", {OrenNayar{kWhite, 0}}},
      {"OrenNayarRough", {OrenNayar{kWhite, 1}}},
      {"GgxMirrorLike", {Ggx{.roughness = 0.01, .f0 = kWhite}}},
      {"GgxGlossy", {Ggx{.roughness = 0.1, .f0 = {0.9, 0.5, 0.04}}}},
      {"GgxRough", {Ggx{.roughness = 1, .f0 = kWhite}}},
      {"GgxDielectric", {Ggx{.roughness = 0.2, .ior = 1.5}}},
      {"RetroNarrow", {Retro{.roughness = 0.05, .strength = kWhite}}},
      {"RetroWide", {Retro{.roughness = 1, .strength = kWhite}}},
      {"Plastic", {Lambert{kWhite}, Ggx{.roughness = 0.1, .ior = 1.5}}},
      {"RoughPlastic", {OrenNayar{kWhite, 1}, Ggx{.roughness = 0.5, .ior = 2.5}}},
      {"GildedWhite", {Lambert{kWhite}, Ggx{.roughness = 0.3, .f0 = {1, 0.8, 0.3}}}},
      {"Cloth", {OrenNayar{kWhite, 0.8}, Retro{.roughness = 0.3, .strength = {0.5, 0.4, 1}}}},
      {"DiffuseOnTop", {Ggx{.roughness = 0.2, .f0 = kWhite}, OrenNayar{{0.5, 1, 0}, 0.5}}},
      {"ThreeLayers",
       {Lambert{kWhite}, Retro{.roughness = 0.2, .strength = kWhite},
        Ggx{.roughness = 0.2, .f0 = kWhite}}},
  };
}

class EveryMaterial : public testing::TestWithParam<Material> {
 protected:
  const AnalyticBrdf brdf_{"material", GetParam().layers};
};

INSTANTIATE_TEST_SUITE_P(Analytic, EveryMaterial, testing::ValuesIn(Materials()),
                         [](const auto& test) { return test.param.label; });

std::vector<DirectionPair> RandomPairs() {
  std::mt19937 random(2);
  std::uniform_real_distribution<double> theta(0, kPi / 2), phi(-kPi, kPi);
  std::vector<DirectionPair> pairs(2000);
  for (DirectionPair& pair : pairs) {
    pair = {FromSpherical(theta(random), phi(random)), FromSpherical(theta(random), phi(random))};
  }
  return pairs;
}

TEST_P(EveryMaterial, IsReciprocal) {
  for (const DirectionPair& pair : RandomPairs()) {
    const Rgb f = *brdf_.Eval(pair), g = *brdf_.Eval(DirectionPair{pair.wo, pair.wi});
    EXPECT_LE((f - g).abs().maxCoeff(), 1e-9 * f.maxCoeff());
  }
}

TEST_P(EveryMaterial, IsNotNegative) {
  for (const DirectionPair& pair : RandomPairs()) EXPECT_GE(brdf_.Eval(pair)->minCoeff(), 0);
}

TEST_P(EveryMaterial, IsFiniteAtGrazingAndAtTheLobesAxes) {
  for (const double theta : {0.0, 1e-9, 1.0, 1.5707, kPi / 2 - 1e-9}) {
    for (const double phi : {0.0, 1e-9, 1.0, kPi - 1e-9, kPi}) {
      for (const double other : {0.0, theta, kPi / 2 - 1e-6}) {
        const auto f =
            brdf_.Eval(DirectionPair{FromSpherical(theta, 0), FromSpherical(other, phi)});
        ASSERT_TRUE(f) << theta << " " << other << " " << phi;
        EXPECT_TRUE(f->isFinite().all()) << theta << " " << other << " " << phi;
      }
    }
  }
}

TEST_P(EveryMaterial, KnowsNothingBelowTheHorizon) {
  EXPECT_FALSE(brdf_.Eval(HalfDiff{1.5, 1.5, 0.1}));
  EXPECT_FALSE(brdf_.Eval(DirectionPair{FromSpherical(1.6, 0), FromSpherical(0.1, 0)}));
  EXPECT_FALSE(brdf_.Eval(HalfDiff{std::nan(""), 0.1, 0.1}));
}

// f_r cos theta_o over all wo, by brute force: fine near the given axis, where the lobe is, so that
// it does not matter how narrow the lobe. Polar angles from `axis` grow like u^3.
Rgb IntegrateAbout(const Eigen::Vector3d& axis, const Brdf& brdf, const Eigen::Vector3d& wi) {
  constexpr int kPolars = 400, kAzimuths = 120;
  const auto rotation = Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitZ(), axis);
  Rgb sum = Rgb::Zero();
  for (int i = 0; i < kPolars; ++i) {
    const double u = (i + 0.5) / kPolars;
    const double theta = kPi * u * u * u;
    const double solid = std::sin(theta) * 3 * kPi * u * u / kPolars * (2 * kPi / kAzimuths);
    for (int j = 0; j < kAzimuths; ++j) {
      const Eigen::Vector3d wo = rotation * FromSpherical(theta, 2 * kPi * (j + 0.5) / kAzimuths);
      if (const auto f = brdf.Eval(DirectionPair{wi, wo})) sum += *f * (wo.z() * solid);
    }
  }
  return sum;
}

TEST_P(EveryMaterial, ReflectsNoMoreThanItReceives) {
  bool retro = false;
  for (const Layer& layer : GetParam().layers) retro |= std::holds_alternative<Retro>(layer);
  for (const double deg : {0.0, 30.0, 60.0, 75.0, 85.0, 89.0}) {
    const Eigen::Vector3d wi = FromSpherical(RadFromDeg(deg), 0.3);
    const Eigen::Vector3d mirrored(-wi.x(), -wi.y(), wi.z());
    const Rgb albedo = IntegrateAbout(retro ? wi : mirrored, brdf_, wi);
    EXPECT_LE(albedo.maxCoeff(), 1.005) << deg << " deg: " << albedo.transpose();
    EXPECT_GT(albedo.maxCoeff(), 0.03) << deg;
  }
}

double At(const Brdf& brdf, double theta_i, double theta_o, double phi) {
  return (*brdf.Eval(DirectionPair{FromSpherical(theta_i, 0), FromSpherical(theta_o, phi)}))[0];
}

TEST(Lambert, IsAlbedoOverPi) {
  const AnalyticBrdf brdf("x", {Lambert{{0.2, 0.5, 1}}});
  const Rgb f = *brdf.Eval(HalfDiff{0.3, 0.5, 1});
  EXPECT_DOUBLE_EQ(f[0], 0.2 / kPi);
  EXPECT_DOUBLE_EQ(f[1], 0.5 / kPi);
  EXPECT_DOUBLE_EQ(f[2], 1 / kPi);
  EXPECT_EQ(brdf.name(), "x");
}

TEST(OrenNayar, IsLambertWhenSmooth) {
  const AnalyticBrdf brdf("x", {OrenNayar{Rgb::Constant(0.6), 0}});
  EXPECT_NEAR(At(brdf, 0.5, 1.0, 2), 0.6 / kPi, 1e-15);
}

TEST(OrenNayar, IsFlatterThanLambertAndBrightTowardsTheLight) {
  const AnalyticBrdf brdf("x", {OrenNayar{kWhite, 0.7}});
  EXPECT_GT(At(brdf, 1.2, 1.2, 0), 1.5 * At(brdf, 1.2, 1.2, kPi));
  // 1 / (pi + (pi/2 - 2/3) sigma) at normal incidence, where the direction-dependent term is 0.
  EXPECT_NEAR(At(brdf, 0, 1.0, 0), 1 / (kPi + (kPi / 2 - 2.0 / 3) * 0.7), 1e-15);
}

TEST(OrenNayar, ReflectsAllLightAtGrazingWhenWhite) {
  const AnalyticBrdf brdf("x", {OrenNayar{kWhite, 0.8}});
  const Eigen::Vector3d wi = FromSpherical(kPi / 2 - 1e-5, 0);
  EXPECT_NEAR(IntegrateAbout(wi, brdf, wi)[0], 1, 2e-3);
}

TEST(Ggx, HasTheClosedFormPeakAtNormalIncidence) {
  const AnalyticBrdf brdf("x", {Ggx{.roughness = 0.2, .f0 = {0.3, 0.5, 1}}});
  const Rgb f = *brdf.Eval(HalfDiff{0, 0, 0});
  const double peak = 1 / (4 * kPi * 0.2 * 0.2);  // D = 1 / (pi alpha^2), G = 1
  EXPECT_NEAR(f[0], 0.3 * peak, 1e-12);
  EXPECT_NEAR(f[2], peak, 1e-12);
}

TEST(Ggx, AgreesWithTheTextbookFormulaOffTheAxis) {
  const double alpha = 0.35, theta_i = 0.4, theta_o = 0.9, phi = 2.2;
  const AnalyticBrdf brdf("x", {Ggx{.roughness = alpha, .f0 = Rgb::Constant(0.04)}});
  const Eigen::Vector3d wi = FromSpherical(theta_i, 0), wo = FromSpherical(theta_o, phi);
  const Eigen::Vector3d h = (wi + wo).normalized();
  const double tan2 = (1 - h.z() * h.z()) / (h.z() * h.z());
  const double d =
      std::pow(alpha, 2) / (kPi * std::pow(h.z(), 4) * std::pow(alpha * alpha + tan2, 2));
  const auto lambda = [&](double theta) {
    return (std::sqrt(1 + std::pow(alpha * std::tan(theta), 2)) - 1) / 2;
  };
  const double g = 1 / (1 + lambda(theta_i) + lambda(theta_o));
  const double f = 0.04 + 0.96 * std::pow(1 - h.dot(wi), 5);
  EXPECT_NEAR(At(brdf, theta_i, theta_o, phi), d * g * f / (4 * wi.z() * wo.z()), 1e-13);
}

TEST(Ggx, FollowsTheExactFresnelTermOfADielectric) {
  const AnalyticBrdf glass("x", {Ggx{.roughness = 0.2, .ior = 1.5}});
  const AnalyticBrdf mirror("x", {Ggx{.roughness = 0.2, .f0 = kWhite}});
  EXPECT_NEAR(At(glass, 0, 0, 0) / At(mirror, 0, 0, 0), 0.04, 1e-14);
  // At Brewster's angle only the s part remains: ((n^2 - 1) / (n^2 + 1))^2 / 2.
  const double brewster = std::atan(1.5);
  EXPECT_NEAR(At(glass, brewster, brewster, kPi) / At(mirror, brewster, brewster, kPi),
              std::pow(1.25 / 3.25, 2) / 2, 1e-14);
}

TEST(Retro, IsTheMirrorImageOfAGgxLobe) {
  const AnalyticBrdf retro("x", {Retro{.roughness = 0.2, .strength = kWhite}});
  const AnalyticBrdf ggx("x", {Ggx{.roughness = 0.2, .f0 = kWhite}});
  for (const DirectionPair& pair : RandomPairs()) {
    const Eigen::Vector3d mirrored(-pair.wi.x(), -pair.wi.y(), pair.wi.z());
    const double f = (*retro.Eval(pair))[0];
    EXPECT_NEAR(f, (*ggx.Eval(DirectionPair{mirrored, pair.wo}))[0], 1e-9 * f);
  }
}

TEST(Retro, IsBrightestBackTowardsTheLight) {
  const AnalyticBrdf retro("x", {Retro{.roughness = 0.2, .strength = kWhite}});
  EXPECT_GT(At(retro, 1, 1, 0), 10 * At(retro, 1, 1, kPi / 2));
  EXPECT_GT(At(retro, 1, 1, 0), 10 * At(retro, 1, 1, kPi));
}

TEST(AnalyticBrdf, AddsAnUpperLayerToWhatItLetsThrough) {
  const AnalyticBrdf paper("x", {Lambert{kWhite}, Lambert{Rgb::Constant(0.25)}});
  EXPECT_NEAR(At(paper, 0.3, 0.8, 1), (0.75 * 0.75 + 0.25) / kPi, 1e-12);
}

TEST(AnalyticBrdfDeathTest, AbortsWithoutLayers) {
  EXPECT_DEATH(AnalyticBrdf("nothing", {}), "nothing");
}

}  // namespace
}  // namespace gonio
