// SPDX-License-Identifier: Apache-2.0
#include "brdf/rgl_table.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <random>

#include "brdf/bilinear_density.h"
#include "core/error.h"
#include "core/units.h"
#include "tests/brdf/tensor_file_writer.h"
#include "tests/core/temp_dir.h"

namespace gonio {
namespace {

using testing::AllOf;
using testing::HasSubstr;

constexpr int kThetas = 3, kGrid = 8, kColours = 4;

// The same visible normals for each theta_i, and the same colour everywhere. `jacobian`: with ndf 3
// and sigma 0.5.
struct Sheet {
  Rgb rgb = Rgb(0.2, 0.4, 0.1);
  bool jacobian = false;
  bool set_means_valid = true;

  TensorFileWriter File() const {
    TensorFileWriter file;
    file.AddBytes("description", {5}, {'s', 'h', 'e', 'e', 't'});
    file.Add("phi_i", {1}, {0});
    file.Add("theta_i", {kThetas}, {0, float(kPi / 4), float(kPi / 2)});
    file.Add("sigma", {2, kGrid}, std::vector<float>(2 * kGrid, 0.5f));
    file.Add("ndf", {2, kGrid}, std::vector<float>(2 * kGrid, 3.0f));
    file.Add("vndf", {1, kThetas, kGrid, kGrid}, std::vector<float>(kThetas * kGrid * kGrid, 2.0f));
    std::vector<float> colours;
    std::vector<std::uint8_t> valid((kThetas * kColours * kColours + 7) / 8, 0);
    for (int t = 0; t < kThetas; ++t) {
      for (int c = 0; c < 3; ++c) {
        colours.insert(colours.end(), kColours * kColours, static_cast<float>(rgb[c]));
      }
      for (int i = 0; i < kColours * kColours; ++i) {
        const int bit = t * kColours * kColours + i;
        const bool above = Above(t, i % kColours, i / kColours);
        if (above == set_means_valid) valid[bit / 8] |= 0x80 >> (bit % 8);
      }
    }
    file.Add("rgb", {1, kThetas, 3, kColours, kColours}, colours);
    file.AddBytes("valid", {valid.size()}, valid);
    file.AddBytes("jacobian", {1}, {std::uint8_t(jacobian)});
    return file;
  }

  // With uniform normals the file's square is that of the half vector's angles.
  static bool Above(int t, int x, int y) {
    const double u = x / (kColours - 1.0);
    const Eigen::Vector3d m = FromSpherical(u * u * kPi / 2, (2 * y / (kColours - 1.0) - 1) * kPi);
    const Eigen::Vector3d wi = FromSpherical(t * kPi / 4, 0);
    return (2 * m.dot(wi) * m - wi).z() > 0;
  }
};

class RglTableTest : public testing::Test {
 protected:
  RglTable Open(const Sheet& sheet) {
    return RglTable::Open(dir_.File("sheet.bsdf", sheet.File().Content()));
  }
  std::string Complaint(const std::string& content) {
    const auto path = dir_.File("bad.bsdf", content);
    return MessageOf<ConfigError>([&] { RglTable::Open(path); });
  }
  TempDir dir_;
};

DirectionPair Pair(double theta_i, double phi_i, double theta_o, double phi_o) {
  return {FromSpherical(RadFromDeg(theta_i), RadFromDeg(phi_i)),
          FromSpherical(RadFromDeg(theta_o), RadFromDeg(phi_o))};
}

TEST_F(RglTableTest, DividesByTheCosineThatFilesHold) {
  const RglTable sheet = Open({});
  EXPECT_EQ(sheet.name(), "sheet");
  EXPECT_EQ(sheet.description(), "sheet");
  for (const double theta_o : {5.0, 30.0, 55.0}) {
    const Rgb f_r = *sheet.EvalDirected(Pair(20, 40, theta_o, 200));
    EXPECT_NEAR(f_r[1], 0.4 / std::cos(RadFromDeg(theta_o)), 1e-6);
  }
}

TEST_F(RglTableTest, AppliesNormalsAndAreaIfTheFileAsksForIt) {
  const Rgb plain = *Open({}).EvalDirected(Pair(20, 0, 30, 180));
  const Rgb scaled = *Open({.jacobian = true}).EvalDirected(Pair(20, 0, 30, 180));
  EXPECT_NEAR(scaled[0], plain[0] * 3 / (4 * 0.5), 1e-6);
}

TEST_F(RglTableTest, FindsOutWhatTheValidBitsMean) {
  const RglTable set = Open({.set_means_valid = true});
  const RglTable clear = Open({.set_means_valid = false});
  for (const DirectionPair& pair :
       {Pair(10, 0, 40, 170), Pair(70, 20, 70, 200), Pair(5, 0, 80, 9)}) {
    const auto a = set.EvalDirected(pair);
    const auto b = clear.EvalDirected(pair);
    ASSERT_EQ(a.has_value(), b.has_value());
    EXPECT_TRUE(!a || (*a == *b).all());
  }
}

TEST_F(RglTableTest, KnowsNothingBelowTheHorizonAndKeepsNegativeColours) {
  const RglTable sheet = Open({.rgb = Rgb(-0.1, 0.4, 0.1)});
  EXPECT_FALSE(sheet.EvalDirected(Pair(20, 0, 95, 180)));
  EXPECT_FALSE(sheet.EvalDirected(Pair(95, 0, 20, 180)));
  EXPECT_LT((*sheet.EvalDirected(Pair(20, 0, 30, 180)))[0], 0);
}

TEST_F(RglTableTest, IsReciprocalAsAReflectance) {
  const RglTable sheet = Open({});
  const DirectionPair pair = Pair(20, 0, 50, 160);
  const Rgb one = *sheet.EvalDirected(pair);
  const Rgb other = *sheet.EvalDirected({pair.wo, pair.wi});
  EXPECT_GT(std::abs(one[0] - other[0]), 0.01);  // the sheet is not
  EXPECT_NEAR((*sheet.Eval(pair))[0], (one[0] + other[0]) / 2, 1e-9);
  EXPECT_NEAR((*sheet.Eval(DirectionPair{pair.wo, pair.wi}))[0], (one[0] + other[0]) / 2, 1e-9);
}

TEST_F(RglTableTest, RefusesWhatIsNoSuchFile) {
  const std::string good = Sheet().File().Content();
  EXPECT_THAT(Complaint("tensor"), AllOf(HasSubstr("bad.bsdf: "), HasSubstr("no tensor file")));
  EXPECT_THAT(Complaint(Sheet().File().Content(2)), HasSubstr("version 2.0"));
  for (std::size_t length = 0; length < good.size(); length += length < 400 ? 1 : 37) {
    EXPECT_THAT(Complaint(good.substr(0, length)), HasSubstr("bad.bsdf: ")) << length;
  }
}

TEST_F(RglTableTest, NamesTheFieldThatIsWrong) {
  const auto changed = [&](const std::string& field, const auto& add) {
    TensorFileWriter file = Sheet().File();
    file.Remove(field);
    add(file);
    return Complaint(file.Content());
  };
  const auto nothing = [](TensorFileWriter&) {};
  EXPECT_THAT(changed("vndf", nothing), HasSubstr("has no field vndf"));
  EXPECT_THAT(changed("jacobian", [](auto& f) { f.Add("jacobian", {1}, {1.0f}); }),
              HasSubstr("field jacobian has float32, must have uint8"));
  EXPECT_THAT(changed("valid", [](auto& f) { f.AddBytes("valid", {1}, {1}); }),
              HasSubstr("field valid has the shape 1, must have 6"));
  EXPECT_THAT(changed("ndf",
                      [](auto& f) {
                        f.Add("ndf", {2, 2}, {1, 1, NAN, 1});
                      }),
              HasSubstr("field ndf holds a number that is not finite"));
  EXPECT_THAT(changed("theta_i",
                      [](auto& f) {
                        f.Add("theta_i", {3}, {0, 1, 0.5f});
                      }),
              HasSubstr("does not ascend"));
  EXPECT_THAT(changed("phi_i",
                      [](auto& f) {
                        f.Add("phi_i", {2}, {0, 1});
                      }),
              HasSubstr("is anisotropic (2 phi_i)"));
  EXPECT_THAT(changed("rgb", [](auto& f) { f.Add("spectra", {1}, {1}); }), HasSubstr("spectral"));
  EXPECT_THAT(changed("sigma",
                      [](auto& f) {
                        f.Add("sigma", {1ull << 62, 8}, {1});
                      }),
              HasSubstr("truncated"));
}

TEST(BilinearDensity, MapsBackAndForth) {
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> uniform(0, 1);
  std::vector<float> values(2 * 5 * 7);
  for (float& value : values) value = static_cast<float>(0.1 + uniform(random));
  const BilinearDensity density(values, 2, 5, 7);
  for (int i = 0; i < 200; ++i) {
    const Point2 at = {uniform(random), uniform(random)};
    for (const int grid : {0, 1}) {
      const Point2 back = density.FromUniform(density.ToUniform(at, grid, 0), grid);
      EXPECT_NEAR(back[0], at[0], 1e-9);
      EXPECT_NEAR(back[1], at[1], 1e-9);
    }
  }
}

TEST(BilinearDensity, IsTheIdentityIfUniform) {
  const BilinearDensity density(std::vector<float>(12, 3.0f), 1, 3, 4);
  const Point2 u = density.ToUniform({0.3, 0.8}, 0, 0);
  EXPECT_NEAR(u[0], 0.3, 1e-9);
  EXPECT_NEAR(u[1], 0.8, 1e-9);
}

// Values of an evaluation written independently in another language, from the paper's formulas.
struct Known {
  const char* material;
  double theta_i, phi_i, theta_o, phi_o;  // deg
  Rgb f_r;
};
const Known kKnown[] = {
    {"acrylic_felt_green_rgb", 10, 0, 20, 180, {0.05120304, 0.08857141, 0.01403856}},
    {"acrylic_felt_green_rgb", 45, 0, 30, 60, {0.02806103, 0.0642122, 0.006932933}},
    {"satin_purple_rgb", 35, 30, 50, 170, {0.2353665, 0.2496583, 0.2460223}},  // `valid` inverted
    {"satin_purple_rgb", 60, 0, 60, 180, {5.100313, 4.338803, 4.799118}},
    {"paper_white_rgb", 10, 0, 20, 180, {0.2699409, 0.2740482, 0.3204964}},  // `valid` inverted
};

TEST(RglFiles, AgreeWithAnIndependentEvaluation) {
  const char* dir = std::getenv("GONIO_DATA_DIR");
  int seen = 0;
  for (const Known& known : kKnown) {
    const std::filesystem::path path =
        std::filesystem::path(dir ? dir : "") / (std::string(known.material) + ".bsdf");
    if (dir == nullptr || !std::filesystem::exists(path)) continue;
    ++seen;
    const Rgb f_r = *RglTable::Open(path).EvalDirected(
        Pair(known.theta_i, known.phi_i, known.theta_o, known.phi_o));
    EXPECT_LT(((f_r - known.f_r) / known.f_r).abs().maxCoeff(), 1e-5) << known.material;
  }
  if (seen == 0) GTEST_SKIP() << "GONIO_DATA_DIR has no RGL files";
}

TEST(RglFiles, ReflectNoMoreThanTheyReceive) {
  const char* dir = std::getenv("GONIO_DATA_DIR");
  int seen = 0;
  for (const char* material : {"acrylic_felt_green_rgb", "satin_purple_rgb", "paper_white_rgb"}) {
    const std::filesystem::path path =
        std::filesystem::path(dir ? dir : "") / (std::string(material) + ".bsdf");
    if (dir == nullptr || !std::filesystem::exists(path)) continue;
    ++seen;
    const RglTable table = RglTable::Open(path);
    std::mt19937_64 random(1);
    std::uniform_real_distribution<double> uniform(0, 1);
    Rgb albedo = Rgb::Zero();
    constexpr int kDirections = 4000;
    for (int i = 0; i < kDirections; ++i) {  // cosine-distributed: the mean is f_r pi
      const Eigen::Vector3d wo =
          FromSpherical(std::acos(std::sqrt(uniform(random))), 2 * kPi * uniform(random));
      albedo += table.EvalDirected({FromSpherical(0.5, 0), wo}).value_or(Rgb::Zero()) * kPi;
    }
    albedo /= kDirections;
    EXPECT_LT(albedo.maxCoeff(), 1.02) << material;
    EXPECT_GT(albedo.maxCoeff(), 0.1) << material;
  }
  if (seen == 0) GTEST_SKIP() << "GONIO_DATA_DIR has no RGL files";
}

}  // namespace
}  // namespace gonio
