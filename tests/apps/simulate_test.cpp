// SPDX-License-Identifier: Apache-2.0
// The question before the rig is booked: how many poses and hours to an error?

#include <nlohmann/json.hpp>

#include "tests/apps/gonio_process.h"

namespace gonio {
namespace {

using nlohmann::json;
using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

class SimulateTarget : public GonioTest {
 protected:
  void LearnPrior() {
    Expect("prior learn satin-paint.yaml glossy-plastic.yaml retro-cloth.yaml --out mine.yaml");
    File("other.yaml", With(Config("materials/satin-paint.yaml"), "0.11, 0.32", "0.21, 0.12"));
  }
  json Simulate(const std::string& arguments) {
    out_ = Expect("simulate --quiet --json m.json " + arguments).out;
    return json::parse(ReadTextFile(work() / "m.json"));
  }
  std::string out_;
};

TEST_F(SimulateTarget, SaysWhenPredictedAndTrueErrorGetThere) {
  LearnPrior();
  const std::string line =
      "--plan plan-information.yaml --prior mine.yaml other.yaml --max-poses 12 --seeds 2 ";
  const json m = Simulate(line + "--target 0.05");
  ASSERT_EQ(m["sessions"].size(), 2u);
  for (const json& session : m["sessions"]) {
    EXPECT_EQ(session["poses"], 12) << "goes on beyond the target";
    const json& stop = session["reached_predicted"];
    EXPECT_LT(stop["poses"], 12);
    EXPECT_LT(stop["duration_s"], session["duration_s"]);
    EXPECT_LT(session["male_at_stop"].get<double>(), 0.03);
    EXPECT_GE(session["male_at_stop"].get<double>(), session["male"].get<double>());
    EXPECT_LE(session["reached_true"]["poses"], 12);
  }
  const json& answer = m["answers"][0];
  EXPECT_EQ(answer["predicted"]["share"], 1);
  EXPECT_LE(answer["predicted"]["hours"]["low"], answer["predicted"]["hours"]["median"]);
  EXPECT_LE(answer["predicted"]["hours"]["median"], answer["predicted"]["hours"]["high"]);
  EXPECT_THAT(out_, AllOf(HasSubstr("To an error of 0.05: median and 80 % interval"),
                          HasSubstr("2 of 2"), HasSubstr("where the rig would stop"),
                          Not(HasSubstr("never")), Not(HasSubstr("nan"))));

  const json never = Simulate(line + "--target 1e-7");
  EXPECT_EQ(never["answers"][0]["predicted"]["share"], 0);
  EXPECT_TRUE(never["answers"][0]["predicted"]["poses"]["median"].is_null());
  EXPECT_TRUE(never["sessions"][0]["reached_true"].is_null());
  EXPECT_THAT(out_, AllOf(HasSubstr("0 of 2"), HasSubstr("never"),
                          HasSubstr("in 2 of 2 sessions the rig would not stop within")));
}

TEST_F(SimulateTarget, DrawsMaterialsFromALearnedPriorWhereNoneIsNamed) {
  LearnPrior();
  const std::string line =
      "--plan plan-information.yaml --prior mine.yaml --max-poses 5 --target 0.02 ";
  const json two = Simulate(line + "--draws 2 --threads 1");
  EXPECT_THAT(out_, HasSubstr("2 drawn from the prior"));
  EXPECT_EQ(two["materials_drawn_from"], "mine");
  ASSERT_EQ(two["sessions"].size(), 2u);
  EXPECT_NE(two["sessions"][0]["male"], two["sessions"][1]["male"]);
  const json three = Simulate(line + "--draws 3 --threads 2");
  ASSERT_EQ(three["sessions"].size(), 3u);
  EXPECT_EQ(three["sessions"][0], two["sessions"][0]);
  EXPECT_EQ(three["sessions"][1], two["sessions"][1]);
  EXPECT_NE(Simulate(line + "--draws 1 --seed 2")["sessions"][0]["male"],
            two["sessions"][0]["male"]);
}

TEST_F(SimulateTarget, WarnsWhereThePriorHasSeenTheMaterial) {
  LearnPrior();
  const std::string warning =
      "gonio: warning: the prior \"mine\" was learned from satin-paint: what follows is too good\n";
  EXPECT_EQ(Gonio("simulate --plan plan-information.yaml plan-random.yaml --prior mine.yaml "
                  "--material satin-paint.yaml --max-poses 3 --quiet")
                .err,
            warning);
  EXPECT_EQ(Gonio("run --prior mine.yaml --max-poses 3 --quiet --out s").err, warning);
}

TEST_F(SimulateTarget, RefusesWhatHasNoAnswer) {
  ExpectRefused(Gonio("simulate --plan plan-information.yaml --target 0.01"), 2,
                {"name a material", "--prior FILE"});
  ExpectRefused(Gonio("simulate --plan plan-random.yaml --target 0 satin-paint.yaml"), 2,
                {"--target"});
  ExpectRefused(Gonio("simulate --plan plan-random.yaml plan-random.yaml "
                      "--material satin-paint.yaml"),
                2, {"two called \"plan-random\""});
}

}  // namespace
}  // namespace gonio
