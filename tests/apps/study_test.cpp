// SPDX-License-Identifier: Apache-2.0
// Fits of tables by every method, studies, plots and renders, as users run them.

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "brdf/analytic.h"
#include "brdf/merl_table.h"
#include "brdf/render/image.h"
#include "core/units.h"
#include "tests/apps/gonio_process.h"

namespace gonio {
namespace {

using nlohmann::json;
using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

constexpr const char* kStudy = R"(version: 1
name: small
materials: ["*.binary"]
methods: [em, joint]
keep_every: [1, 3]
colours: [red, blue]
slice_step_deg: 15
phi_stride: 30
)";

class Studies : public GonioTest {
 protected:
  // A table of an analytic material.
  void Table(const std::string& name, double roughness) {
    const AnalyticBrdf brdf(name,
                            {Lambert{{0.2, 0.3, 0.4}}, Ggx{.roughness = roughness, .ior = 1.5}});
    std::filesystem::create_directories(work() / "data");
    MerlTable::FromFunction(name, [&](const HalfDiff& x) {
      return brdf.Eval(x);
    }).Write(work() / "data" / (name + ".binary"));
  }
  json Read(const std::string& file) { return json::parse(ReadTextFile(work() / file)); }
  auto Written(const std::string& file) { return std::filesystem::last_write_time(work() / file); }
};

TEST_F(Studies, MeasureEveryCellAndGoOnWhereTheyStopped) {
  Table("paint", 0.3);
  Table("satin", 0.15);
  File("s.yaml", kStudy);
  const std::string run = "study s.yaml --materials data --out out";
  EXPECT_THAT(Expect(run).out, AllOf(HasSubstr("2 materials, 8 fits, 0 of them done before"),
                                     HasSubstr("8 of 8 fits"), HasSubstr("MALE stays within")));
  const json study = Read("out/study.json");
  ASSERT_EQ(study["cells"].size(), 16u);  // 2 materials x 2 methods x 2 thinnings x 2 colours
  for (const json& cell : study["cells"]) {
    EXPECT_GT(cell["male"].get<double>(), 0);
    EXPECT_LT(cell["male"].get<double>(), 0.1);
  }
  EXPECT_EQ(study["summary"].size(), 2u);
  const std::string csv = ReadTextFile(work() / "out/cells.csv");
  EXPECT_EQ(std::count(csv.begin(), csv.end(), '\n'), 17);
  EXPECT_TRUE(std::filesystem::exists(work() / "out/figures/density.png"));

  // One cell lost, one torn, as a kill or a full disk leaves them: only these are done again.
  std::filesystem::remove(work() / "out/cells/paint/em-1.json");
  File("out/cells/satin/joint-3.json", "{\"key\": ");
  const auto before = Written("out/cells/paint/joint-1.json");
  EXPECT_THAT(Expect(run + " --quiet").out, HasSubstr("8 fits, 6 of them done before"));
  EXPECT_EQ(Written("out/cells/paint/joint-1.json"), before);
  EXPECT_EQ(Read("out/study.json"), study);

  // Another option is another result.
  File("s.yaml", std::string(kStudy) + "lobes: 2\n");
  EXPECT_THAT(Expect(run).out, HasSubstr("8 fits, 0 of them done before"));
}

TEST_F(Studies, DoNotDependOnTheNumberOfThreads) {
  Table("paint", 0.3);
  File("s.yaml", kStudy);
  Expect("study s.yaml --materials data --out one --threads 1");
  Expect("study s.yaml --materials data --out two --threads 2");
  EXPECT_EQ(ReadTextFile(work() / "one/cells.csv"), ReadTextFile(work() / "two/cells.csv"));
  EXPECT_EQ(Read("one/study.json"), Read("two/study.json"));
}

TEST_F(Studies, GoOnAfterAMaterialThatCannotBeReadOrFitted) {
  Table("paint", 0.3);
  File("data/broken.binary", "no table");
  std::string yaml = kStudy;
  yaml.replace(yaml.find("[1, 3]"), 6, "[1, 45]");  // 2 points for 6 parameters
  File("s.yaml", yaml);
  const Finished run = Gonio("study s.yaml --materials data --out out");
  EXPECT_EQ(run.code, 1);
  EXPECT_THAT(
      run.err,
      AllOf(HasSubstr("gonio: broken, em, density 100 %, red: "), HasSubstr("broken.binary: "),
            HasSubstr("gonio: paint, joint, density 2.22 %, blue: theta_d 0.5 deg: 2 valid "
                      "readings for the 6 parameters of 3 lobes")));
  EXPECT_THAT(run.out, HasSubstr("failed           12 of 16 cells"));
}

TEST_F(Studies, ContinueAfterBeingStopped) {
  Table("paint", 0.3);
  Table("satin", 0.15);
  File("s.yaml", kStudy);
  const Finished stopped = Shell(
      "\"$GONIO\" study s.yaml --materials data --out out --threads 1 & pid=$!; "
      "until ls out/cells/*/*.json >/dev/null 2>&1; do :; done; kill -INT $pid; wait $pid");
  EXPECT_EQ(stopped.code, 3);
  EXPECT_THAT(stopped.out, HasSubstr("stopped; the same command goes on from here"));
  EXPECT_THAT(Expect("study s.yaml --materials data --out out").out,
              AllOf(HasSubstr("8 fits, "), Not(HasSubstr("8 fits, 0 of them"))));
}

TEST_F(Studies, RefuseFilesThatAreWrong) {
  Table("paint", 0.3);
  const auto refuse = [&](const std::string& from, const std::string& to, const std::string& why) {
    std::string yaml = kStudy;
    yaml.replace(yaml.find(from), from.size(), to);
    File("s.yaml", yaml);
    ExpectRefused(Gonio("study s.yaml --materials data --out x"), 2, {why});
  };
  refuse("[em, joint]", "[em, magic]", "s.yaml:4: methods: holds \"magic\"");
  refuse("[1, 3]", "[0, 3]", "s.yaml:5: keep_every");
  refuse("[1, 3]", "[3, 3]", "holds 3 twice");
  refuse("*.binary", "gold.binary", "nothing is called \"gold.binary\" in data");
  refuse("name: small", "name: small\nlobs: 3", "s.yaml:3: lobs");
  ExpectRefused(Gonio("study none.yaml --out x"), 2, {"none.yaml: no such file"});
}

TEST_F(Studies, AreDrawn) {
  Table("paint", 0.3);
  File("s.yaml", kStudy);
  Expect("study s.yaml --materials data --out out");
  Expect("plot out --out d.svg");
  Expect("plot out --method em --out d.png");
  EXPECT_THAT(ReadTextFile(work() / "d.svg"), AllOf(HasSubstr("<svg"), HasSubstr("median of 1")));
  ExpectRefused(Gonio("plot out --method continuous --out d.png"), 2, {"no method continuous"});
  ExpectRefused(Gonio("plot out --kind slice --out d.png"), 2, {"is a study: there is no slice"});
  ExpectRefused(Gonio("plot out --out d.pdf"), 2, {"must be .png or .svg"});
}

TEST_F(Studies, FitsOfEachMethodAreExportedDrawnAndCompared) {
  Table("paint", 0.3);
  for (const std::string method : {"em", "joint", "continuous"}) {
    const std::string fit = method + ".yaml";
    EXPECT_THAT(Expect("fit data/paint.binary --method " + method + " --out " + fit).out,
                AllOf(HasSubstr("times smaller"), HasSubstr("MALE")));
    Expect("export " + fit + " --to merl " + method + ".binary");
    Expect("compare " + fit + " " + method + ".binary --no-render --phi-stride 30 --json m.json");
    EXPECT_LT(Read("m.json")["male"].get<double>(), 1e-9);
    Expect("plot " + fit + " --reference data/paint.binary --out slice.svg");
    EXPECT_THAT(ReadTextFile(work() / "slice.svg"), HasSubstr("data"));
  }
  Expect(
      "plot joint.yaml --kind error-map --reference data/paint.binary --colour blue --out e.png");
  ExpectRefused(Gonio("plot joint.yaml --kind error-map --out e.png"), 2, {"needs --reference"});
  ExpectRefused(Gonio("plot data/paint.binary --out e.png"), 2,
                {"neither a fit file nor a session"});
  EXPECT_THAT(
      Expect("fit data/paint.binary --method joint --lobes auto --keep-every 3 --out a.yaml").out,
      HasSubstr("lobes"));
  ExpectRefused(Gonio("fit joint.yaml --out b.yaml"), 2, {"is a fit already"});
}

TEST_F(Studies, AColourThatIsMissingCostsNoOther) {
  Table("paint", 0.3);
  const MerlTable table = MerlTable::Open(work() / "data/paint.binary");
  std::string csv =
      "theta_i_deg,phi_i_deg,theta_o_deg,phi_o_deg,f_r_red,f_r_green,f_r_blue,sigma_blue\n";
  for (int i = 2; i < 75; i += 6) {
    for (int o = 1; o < 75; o += 4) {
      const DirectionPair pair = {FromSpherical(RadFromDeg(i), 0), FromSpherical(RadFromDeg(o), 3)};
      const Rgb f_r = *table.Eval(pair);
      csv += fmt::format("{},0,{},{},{},{},0,inf\n", i, o, DegFromRad(3), f_r[0], f_r[1]);
    }
  }
  File("two.csv", csv);
  for (const std::string method : {"em", "joint", "continuous"}) {
    const Finished run = Gonio("fit two.csv --method " + method + " --lobes 2 --out f.yaml");
    EXPECT_EQ(run.code, 1);
    EXPECT_THAT(run.err, AllOf(HasSubstr("gonio: two, blue: "), HasSubstr("no reading is valid")));
    EXPECT_THAT(run.err, Not(HasSubstr("gonio: two, red")));
    Expect("compare data/paint.binary f.yaml --no-render --phi-stride 30 --json m.json");
    const json male = Read("m.json")["male_per_channel"];
    EXPECT_LT(male[0].get<double>(), 0.05);
    if (method == "continuous") continue;  // the prior has blue follow the other colours
    EXPECT_TRUE(male[2].is_null());
    ExpectRefused(Gonio("export f.yaml --to merl t.binary"), 2,
                  {"f.yaml: has no blue", "a table needs all three colours"});
  }
}

TEST_F(Studies, MaterialsBecomeTables) {
  Expect("export satin-paint.yaml --to merl satin.binary");
  Expect("compare satin-paint.yaml satin.binary --no-render --phi-stride 30 --json m.json");
  EXPECT_LT(Read("m.json")["male"].get<double>(), 1e-9);
  ExpectRefused(Gonio("export satin-paint.yaml --to csv s.csv"), 2, {"satin-paint.yaml"});
  ExpectRefused(Gonio("export none.bsdf --to merl t.binary"), 2, {"none.bsdf: no such file"});
}

TEST_F(Studies, MaterialsAreRendered) {
  const Finished run = Expect(
      "render satin-paint.yaml glossy-plastic.yaml --size 40 --out r.png --out r.exr --out r.hdr");
  EXPECT_THAT(run.out, HasSubstr("rendered         80 x 40 pixels"));
  const Image image = ReadImage(work() / "r.exr");
  EXPECT_EQ(image.width, 80);
  EXPECT_GT(image.at(20, 20)[1], 0.01f);
  EXPECT_EQ(image.at(0, 0)[1], 0);
  Expect("render satin-paint.yaml --light env --size 24 --samples 12 --out e.png");
  Image light(16, 8);
  for (Eigen::Array3f& pixel : light.pixels) pixel.setOnes();
  WriteImage(work() / "white.hdr", light);
  Expect(
      "render satin-paint.yaml --light env --environment white.hdr --size 24 --samples 12 --out "
      "e.hdr");
  ExpectRefused(Gonio("render satin-paint.yaml --out r.jpg"), 2, {"must be .png, .hdr or .exr"});
  ExpectRefused(Gonio("render satin-paint.yaml --environment white.hdr --out r.png"), 2,
                {"needs --light env"});
  ExpectRefused(Gonio("render satin-paint.yaml --exposure -1 --out r.png"), 2, {"--exposure"});
  ExpectRefused(Gonio("render none.binary --out r.png"), 2, {"none.binary: no such file"});
}

TEST_F(Studies, RendersAreComparedToo) {
  Table("paint", 0.3);
  Table("satin", 0.15);
  const std::string out =
      Expect("compare data/paint.binary data/satin.binary --phi-stride 30 --json m.json").out;
  EXPECT_THAT(out, AllOf(HasSubstr("render, point"), HasSubstr("render, sky"), HasSubstr("FLIP")));
  const json m = Read("m.json");
  EXPECT_GT(m["render_point"]["flip"].get<double>(), 0);
  EXPECT_GT(m["render_env"]["delta_e_itp"].get<double>(), 0);
  EXPECT_LT(m["render_env"]["ssim"].get<double>(), 1);
}

}  // namespace
}  // namespace gonio
