// SPDX-License-Identifier: Apache-2.0
// --prior none, generic or FILE, as users name them.

#include <nlohmann/json.hpp>

#include "tests/apps/gonio_process.h"

namespace gonio {
namespace {

using nlohmann::json;
using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

class PriorOption : public GonioTest {
 protected:
  PriorOption() {
    WriteCoatings();
    Expect(
        "prior learn data/enamel.yaml data/glaze.yaml data/lacquer.yaml data/paint.yaml "
        "--out learned.yaml");
  }
};

TEST_F(PriorOption, IsTakenByWhateverFits) {
  for (const std::string prior : {"none", "generic", "learned.yaml"}) {
    const std::string name = prior.substr(0, prior.find('.'));
    const std::string named = "prior \"" + name + "\"";
    EXPECT_THAT(Expect("run --material data/rubber.yaml --max-poses 10 --quiet --out s-" + name +
                       " --prior " + prior)
                    .out,
                AllOf(HasSubstr(named), Not(HasSubstr("nan"))));
    EXPECT_THAT(Expect("fit s-" + name + " --out " + name + "-fit.yaml --prior " + prior).out,
                HasSubstr(named));
    Expect(
        "simulate --plan plan-random.yaml --material data/rubber.yaml --max-poses 10 --quiet "
        "--json " +
        name + ".json --prior " + prior);
    const json m = json::parse(ReadTextFile(work() / (name + ".json")));
    EXPECT_EQ(m["sessions"][0]["prior"], name);
    EXPECT_LT(m["sessions"][0]["male"].get<double>(), 0.1);
    // The session finds its prior again.
    EXPECT_THAT(Expect("compare data/rubber.yaml s-" + name + " --no-render").out,
                HasSubstr("MALE"));
  }
}

TEST_F(PriorOption, OfAPlanMayBeNone) {
  File("plan.yaml", With(Config("plan-information.yaml"), "prior: generic", "prior: none"));
  EXPECT_THAT(Expect("run --plan plan.yaml --max-poses 9 --quiet --out s").out,
              HasSubstr("prior \"none\""));
}

TEST_F(PriorOption, IsRefusedWhereItIsBroken) {
  const std::string good = ReadTextFile(work() / "learned.yaml");
  const auto refuse = [&](const std::string& from, const std::string& to, const std::string& why) {
    File("bad.yaml", With(good, from, to));
    for (const char* command : {"run --out s", "fit data/rubber.yaml --out f.yaml",
                                "simulate --plan plan-random.yaml --material data/rubber.yaml"}) {
      ExpectRefused(Gonio(std::string(command) + " --prior bad.yaml"), 2, {"bad.yaml:", why});
    }
  };
  refuse("\nversion: 1", "\nversion: 7", "version: is 7");
  refuse("theta_h_knots: 28", "theta_h_knots: 27", "process.mean: must be a list of 1296 numbers");
  refuse("  stationary_chroma: [", "  stationary_chroma: [-1, ", "process.stationary_chroma");
  EXPECT_FALSE(std::filesystem::exists(work() / "s"));
}

// A target that noise and model forbid ends the session all the same, and it says why.
TEST_F(PriorOption, StopsWhereNothingMoreIsToBeGained) {
  File("plan.yaml",
       "version: 1\nname: fine\nplanner: information\nmax_poses: 400\n"
       "information: {target_error: 1.0e-5}\n");
  const Finished run = Expect(
      "run --plan plan.yaml --prior learned.yaml --material data/rubber.yaml --quiet --out s");
  EXPECT_THAT(run.out, HasSubstr("session          complete: target error is below what the model "
                                 "can reach; nothing more to gain"));
}

}  // namespace
}  // namespace gonio
