// SPDX-License-Identifier: Apache-2.0
// Whole tables, by each method: how near, what cannot be fitted, and the file.

#include "fitting/table_fit.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "brdf/metrics.h"
#include "core/error.h"
#include "core/file.h"
#include "tests/brdf/function_brdf.h"
#include "tests/core/temp_dir.h"
#include "tests/fitting/synthetic.h"

namespace gonio {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::IsEmpty;
using testing::SizeIs;
using testing::StartsWith;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

// Coarse in phi_d and theta_d: enough for these materials, and quick under sanitizers.
TableFitOptions Options(FitMethod method) {
  TableFitOptions options;
  options.method = method;
  options.slices.phi_stride = 12;
  options.slices.step = RadFromDeg(10);
  options.knots = 7;
  return options;
}

double Male(const Brdf& truth, const Brdf& fit) {
  return Compare(truth, fit, {.phi_stride = 30}).male;
}

class Methods : public testing::TestWithParam<FitMethod> {};
INSTANTIATE_TEST_SUITE_P(All, Methods,
                         testing::Values(FitMethod::kEm, FitMethod::kJoint, FitMethod::kContinuous),
                         [](const auto& each) { return std::string(NameOf(each.param)); });

TEST_P(Methods, FitAMaterialOfTheFamily) {
  const Dsbrdf truth = SyntheticMaterial(3);
  const TableFit fit = FitTable(truth, Options(GetParam()));
  ASSERT_NE(fit.model, nullptr);
  EXPECT_THAT(fit.failures, IsEmpty());
  EXPECT_EQ(fit.model->lobes(), 3);
  EXPECT_LT(Male(truth, *fit.model), GetParam() == FitMethod::kEm ? 0.1 : 0.004);
}

TEST_P(Methods, LeaveOtherColoursAloneWhenOneIsMissing) {
  const Dsbrdf truth = SyntheticMaterial(4);
  const FunctionBrdf no_blue([&](const HalfDiff& x) -> std::optional<Rgb> {
    std::optional<Rgb> f_r = truth.Eval(x);
    if (f_r) (*f_r)[2] = kNan;
    return f_r;
  });
  const TableFit fit = FitTable(no_blue, Options(GetParam()));
  ASSERT_NE(fit.model, nullptr);
  ASSERT_THAT(fit.failures, SizeIs(1));
  EXPECT_EQ(fit.failures[0].channel, 2);
  EXPECT_THAT(fit.failures[0].reason, HasSubstr("no reading is valid"));
  const HalfDiff at{0.2, 0.5, 1.5};
  const double red = (*fit.model->Eval(at))[0];
  const double alone = (*FitTable(truth, Options(GetParam())).model->Eval(at))[0];
  // Colours are tied by the continuous fit's prior, and else not at all.
  EXPECT_NEAR(red, alone, GetParam() == FitMethod::kContinuous ? 0.02 * alone : 0);
}

TEST_P(Methods, FindNothingToFitWhereNothingIsKnown) {
  const FunctionBrdf nothing([](const HalfDiff&) { return std::optional<Rgb>(); });
  const TableFit fit = FitTable(nothing, Options(GetParam()));
  EXPECT_EQ(fit.model, nullptr);
  ASSERT_THAT(fit.failures, SizeIs(3));
  EXPECT_THAT(fit.failures[1].reason, HasSubstr("no reading is valid"));
}

TEST_P(Methods, KeepTheirFit) {
  const TempDir dir;
  const TableFit fit = FitTable(SyntheticMaterial(5), Options(GetParam()));
  WriteFit(dir / "fit.yaml", *fit.model);
  const std::unique_ptr<LobeModel> read = ReadAnyFit(dir / "fit.yaml");
  EXPECT_THAT(ReadTextFile(dir / "fit.yaml"),
              HasSubstr(std::string("version: 2\nmethod: ") + std::string(NameOf(GetParam()))));
  EXPECT_EQ(read->name(), "fit.yaml");
  for (const HalfDiff& at : {HalfDiff{0.02, 0.1, 1}, HalfDiff{0.7, 0.9, 1.5}}) {
    EXPECT_TRUE(((*read->Eval(at) - *fit.model->Eval(at)).abs() < 1e-12).all());
  }
  const auto* sliced = dynamic_cast<const SlicedDsbrdf*>(read.get());
  if (sliced == nullptr) return;
  const auto& original = dynamic_cast<const SlicedDsbrdf&>(*fit.model);
  ASSERT_EQ(sliced->reports().size(), original.reports().size());
  EXPECT_EQ(sliced->reports()[3].iterations, original.reports()[3].iterations);
  EXPECT_EQ(sliced->parameter_count(), fit.parameters);
}

TEST_P(Methods, RefuseLobesOutOfRange) {
  TableFitOptions options = Options(GetParam());
  options.lobes = 6;
  EXPECT_EQ(MessageOf<ConfigError>([&] { FitTable(SyntheticMaterial(1), options); }),
            "lobes: is 6, must be 1 to 5");
}

TEST(TableFit, LeavesOutSlicesThatCannotBeFitted) {
  const Dsbrdf truth = SyntheticMaterial(6);
  const FunctionBrdf gap([&](const HalfDiff& x) -> std::optional<Rgb> {
    if (x.theta_d > RadFromDeg(28) && x.theta_d < RadFromDeg(32)) return std::nullopt;
    return truth.Eval(x);
  });
  const TableFit fit = FitTable(gap, Options(FitMethod::kJoint));
  EXPECT_THAT(fit.failures, IsEmpty());
  ASSERT_THAT(fit.warnings, SizeIs(3));
  EXPECT_EQ(fit.warnings[1].reason, "theta_d 30.5 deg: no reading is valid");
  EXPECT_LT(Male(truth, *fit.model), 0.01);
}

TEST(TableFit, FailsWhenThinningLeavesTooLittle) {
  TableFitOptions options = Options(FitMethod::kEm);
  options.slices.keep_every = 20;  // 5 of 90 points for 6 parameters
  const TableFit fit = FitTable(SyntheticMaterial(1), options);
  EXPECT_EQ(fit.model, nullptr);
  EXPECT_THAT(fit.failures[0].reason,
              AllOf(StartsWith("theta_d 0.5 deg: 5 valid readings for the 6 parameters of 3 lobes"),
                    HasSubstr("likewise 8 more of 9 slices")));
}

TEST(TableFit, FailsOnNegativeData) {
  const FunctionBrdf negative([](const HalfDiff& x) { return Rgb(1, x.theta_h > 1 ? -1 : 1, 1); });
  const TableFit fit = FitTable(negative, Options(FitMethod::kJoint));
  ASSERT_THAT(fit.failures, SizeIs(1));
  EXPECT_EQ(fit.failures[0].channel, 1);
  EXPECT_THAT(fit.failures[0].reason, HasSubstr("negative"));
}

TEST(TableFit, RemarksOnConstantDataAndFitsIt) {
  const FunctionBrdf white([](const HalfDiff&) { return Rgb::Constant(0.3); });
  const TableFit fit = FitTable(white, Options(FitMethod::kJoint));
  ASSERT_THAT(fit.warnings, SizeIs(3));
  EXPECT_THAT(fit.warnings[0].reason, HasSubstr("every reading is the same"));
  EXPECT_NEAR((*fit.model->Eval(HalfDiff{0.5, 0.5, 1.5}))[0], 0.3, 0.01);
}

TEST(TableFit, BicFindsHowManyLobesThereAre) {
  for (const int lobes : {1, 2}) {
    const Dsbrdf truth = SyntheticMaterial(7, {.lobes = lobes, .knots = 7});
    TableFitOptions options = Options(FitMethod::kJoint);
    options.channels = {false, true, false};
    EXPECT_EQ(FitTableChoosingLobes(truth, options).model->lobes(), lobes);
  }
}

TEST(TableFit, FitsScatteredSamplesSliceBySlice) {
  const Dsbrdf truth = SyntheticMaterial(8);
  const std::vector<BrdfSample> samples = Readings(truth, 800, 0.01, 1);
  const TableFit fit = FitSamples(samples, Options(FitMethod::kJoint));
  ASSERT_NE(fit.model, nullptr);
  EXPECT_LT(Male(truth, *fit.model), 0.03);
}

TEST(SlicedDsbrdf, IsItsSlicesAndUnknownWhereItHasNone) {
  std::array<std::vector<FittedSlice>, kChannels> slices;
  slices[1] = {{0.2, {{0.5, 2}}}, {0.8, {{0.7, 5}}}};
  const SlicedDsbrdf model(SliceMethod::kJoint, slices, {});
  EXPECT_NEAR(model.LobesAt(0.8, 1)[0].gamma, 5, 1e-12);
  EXPECT_NEAR(model.LobesAt(0.0, 1)[0].kappa, 0.5, 1e-12);
  EXPECT_NEAR(model.LobesAt(0.5, 1)[0].gamma, std::sqrt(10.0), 1e-9);  // log gamma is interpolated
  EXPECT_THAT(model.LobesAt(0.5, 0), IsEmpty());
  const Rgb f_r = *model.Eval(HalfDiff{0.3, 0.8, 1.5});
  EXPECT_NEAR(f_r[1], std::expm1(0.7 * std::pow(std::cos(0.3), 5)), 1e-12);
  EXPECT_TRUE(std::isnan(f_r[0]) && std::isnan(f_r[2]));
  EXPECT_THROW(SlicedDsbrdf(SliceMethod::kEm, {}, {}), ConfigError);
}

constexpr const char* kFile =
    "format: gonio-fit\nversion: 2\nmethod: joint\nlobes: 1\n"
    "green:\n  theta_d_deg: [5, 10]\n  kappa: [0.5, 0.6]\n  gamma: [2, 3]\n";

TEST(SlicedFile, RefusesWhatIsBroken) {
  const TempDir dir;
  const auto message = [&](const std::string& from, const std::string& to) {
    std::string text = kFile;
    text.replace(text.find(from), from.size(), to);
    const auto path = dir.File("f.yaml", text);
    return MessageOf<ConfigError>([&] { ReadAnyFit(path); });
  };
  EXPECT_NE(ReadAnyFit(dir.File("good.yaml", kFile)), nullptr);
  EXPECT_THAT(message("[0.5, 0.6]", "[0.5, -0.6]"), HasSubstr("f.yaml:7: green.kappa"));
  EXPECT_THAT(message("[2, 3]", "[2]"), HasSubstr("f.yaml:8: green.gamma"));
  EXPECT_THAT(message("[5, 10]", "[10, 5]"), HasSubstr("theta_d_deg: must ascend"));
  EXPECT_THAT(message("joint", "jiont"), HasSubstr("f.yaml:3: method"));
  EXPECT_THAT(message("lobes: 1", "lobes: 1\nlopes: 1"), HasSubstr("lopes"));
  EXPECT_THAT(message("version: 2", "version: 3"), HasSubstr("f.yaml:2: version"));
}

}  // namespace
}  // namespace gonio
