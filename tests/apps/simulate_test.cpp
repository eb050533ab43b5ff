// SPDX-License-Identifier: Apache-2.0
// The question before the rig is booked: how many poses and hours to an error?

#include <nlohmann/json.hpp>
#include <sstream>

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
  // The first line of the output that holds `text`.
  std::string LineWith(const std::string& text) const {
    std::istringstream lines(out_);
    for (std::string line; std::getline(lines, line);) {
      if (line.find(text) != std::string::npos) return line;
    }
    return "";
  }
  std::string out_;
};

TEST_F(SimulateTarget, SaysWhenPredictedAndTrueErrorGetThere) {
  LearnPrior();
  const std::string line = "--prior mine.yaml other.yaml --max-poses 12 --seeds 2 ";
  // What the rig does when it is told to stop there.
  File("stops.yaml",
       With(Config("plan-information.yaml"), "target_error: 0 ", "target_error: 0.018 "));
  const json stopped = Simulate("--plan stops.yaml " + line);
  const json m = Simulate("--plan plan-information.yaml --target 0.018 " + line);
  ASSERT_EQ(m["sessions"].size(), 2u);
  double hours = 0;
  for (std::size_t i = 0; i < 2; ++i) {
    const json& session = m["sessions"][i];
    EXPECT_EQ(session["poses"], 12) << "goes on beyond the target";
    EXPECT_GT(session["predicted_error"], 0);
    EXPECT_LE(session["predicted_error"], 0.018);
    const json& stop = session["reached_predicted"];
    EXPECT_GT(stop["poses"], 4);
    EXPECT_LT(stop["poses"], 12);
    EXPECT_EQ(stop["poses"], stopped["sessions"][i]["poses"]);
    EXPECT_EQ(stop["duration_s"], stopped["sessions"][i]["duration_s"]);
    EXPECT_LT(stop["duration_s"], session["duration_s"]);
    hours += stop["duration_s"].get<double>() / 3600 / 2;
    // Looked at less closely than at the end of a session.
    const double male = stopped["sessions"][i]["male"];
    EXPECT_NEAR(session["male_at_stop"].get<double>(), male, 0.1 * male);
    EXPECT_LE(session["reached_true"]["poses"], stop["poses"]);
  }
  const json& predicted = m["answers"][0]["predicted"];
  EXPECT_EQ(predicted["share"], 1);
  const double poses = predicted["poses"]["median"];
  EXPECT_EQ(2 * poses, m["sessions"][0]["reached_predicted"]["poses"].get<double>() +
                           m["sessions"][1]["reached_predicted"]["poses"].get<double>());
  EXPECT_NEAR(predicted["hours"]["median"].get<double>(), hours, 1e-9);
  EXPECT_LT(predicted["hours"]["low"], predicted["hours"]["median"]);
  EXPECT_LT(predicted["hours"]["median"], predicted["hours"]["high"]);
  const std::string said = LineWith("predicted ");
  EXPECT_THAT(said, AllOf(HasSubstr("2 of 2"), HasSubstr(fmt::format(" {:.0f} (", poses)),
                          HasSubstr(fmt::format(" {:.3f} (", hours))));
  EXPECT_THAT(out_, AllOf(HasSubstr("To an error of 0.018: median and 80 % interval"),
                          HasSubstr("where the rig would stop"), Not(HasSubstr("never")),
                          Not(HasSubstr("nan"))));
}

TEST_F(SimulateTarget, SaysNeverWhereNothingGetsThere) {
  LearnPrior();
  const json never = Simulate(
      "--plan plan-information.yaml --prior mine.yaml other.yaml --max-poses 5 --seeds 2 "
      "--target 1e-7");
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
