// SPDX-License-Identifier: Apache-2.0
// gonio report: the page, and what happens when it cannot be made.

#include <filesystem>
#include <fstream>
#include <regex>
#include <set>

#include "fitting/prior.h"
#include "tests/apps/gonio_process.h"

namespace gonio {
namespace {

using testing::Contains;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

// Every match of the first group of `pattern`, in order.
std::vector<std::string> All(const std::string& text, const std::string& pattern) {
  const std::regex regex(pattern);
  std::vector<std::string> found;
  for (std::sregex_iterator it(text.begin(), text.end(), regex), end; it != end; ++it) {
    found.push_back((*it)[1]);
  }
  return found;
}

// Those of `words` that a page, which is too long to print, does not hold.
std::vector<std::string> Missing(const std::string& page, const std::vector<std::string>& words) {
  std::vector<std::string> missing;
  for (const std::string& word : words) {
    if (page.find(word) == std::string::npos) missing.push_back(word);
  }
  return missing;
}

class Report : public GonioTest {
 protected:
  void Run(const std::string& arguments) { Expect("run --quiet --out s " + arguments); }
  // "1 min 11 s" in the table of times, in seconds.
  double HomingOf(const std::string& session) {
    Expect("report " + session);
    const std::regex row("<th>Homing</th>.*<td>(?:([0-9]+) min )?([0-9]+) s</td></tr>");
    std::smatch match;
    const std::string page = Page(session + "/report.html");
    EXPECT_TRUE(std::regex_search(page, match, row));
    return 60 * (match[1].matched ? std::stod(match[1]) : 0) + std::stod(match[2]);
  }
  std::string Page(const std::string& name = "s/report.html") {
    return ReadTextFile(work() / name);
  }
};

// Example failure is a prior looked for beside the caller, not beside the plan that names it.
TEST_F(Report, FindsThePriorThatThePlanNames) {
  std::filesystem::create_directory(work() / "plans");
  WritePrior(work() / "plans/mine.yaml", GenericPrior());
  std::ofstream(work() / "plans/plan.yaml")
      << "version: 1\nname: mine\nplanner: information\nmax_poses: 12\n"
         "fit: {prior: mine.yaml}\n";
  Run("--plan plans/plan.yaml");
  Expect("report s");
  EXPECT_THAT(Missing(Page(), {"Nothing unusual"}), IsEmpty());
}

// Example failure is a report that takes the time of a resume's homing for that of the session.
TEST_F(Report, SaysWhatTimeWasPredictedAndWhatItTook) {
  Run("--max-poses 10");
  const double whole = HomingOf("s");
  Expect("run --quiet --out r --max-poses 4");
  EXPECT_EQ(Gonio("run --quiet --resume r --max-poses 8 --accept-changed").code, 0);
  EXPECT_NEAR(HomingOf("r"), 2 * whole, 2);
  Expect("report s");
  const auto percent = All(Page(), "and they took [^:]*: ([+-][0-9.]+) %");
  ASSERT_EQ(percent.size(), 1u);
  EXPECT_LT(std::abs(std::stod(percent[0])), 20);  // frames for darker channels are not foreseen
}

TEST_F(Report, ShowsWhatWasMeasuredHowGoodItIsAndWhatItSaved) {
  Run("--max-poses 14");
  EXPECT_THAT(Expect("report s").out, HasSubstr("s/report.html"));
  const std::string page = Page();
  EXPECT_THAT(
      All(page, "<section id=\"([a-z]+)\""),
      ElementsAre("session", "poses", "slices", "error", "time", "lobes", "samples", "identities"));
  EXPECT_EQ(All(page, "<svg role=\"(img)\"").size(), 8u);
  EXPECT_THAT(Missing(page, {"satin paint", "error (MALE)", "expected error", "of a dense scan",
                             "of the time saved", "complete: pose", "Nothing unusual",
                             "Rig file, SHA-256"}),
              IsEmpty());
  const std::vector<std::string> unwanted = {">nan", ">inf<", "NaN", "<title>gnuplot"};
  EXPECT_EQ(Missing(page, unwanted), unwanted);
  EXPECT_EQ(All(page, "<tr><td>([0-9]+)</td><td class=\"text\">").size(), 14u);
}

TEST_F(Report, IsOneFileThatNeedsNothingElse) {
  Run("--max-poses 10");
  Expect("report s --out page.html");
  const std::string page = Page("page.html");
  const std::vector<std::string> unwanted = {"<script", "<link", "<img", "<image", "@import"};
  EXPECT_EQ(Missing(page, unwanted), unwanted);
  for (const std::string& attribute : All(page, "([a-z:]+=[\"']?https?://)")) {
    EXPECT_THAT(attribute, testing::StartsWith("xmlns"));
  }
  for (const std::string& reference : All(page, "href=[\"']([^\"']*)")) {
    EXPECT_THAT(reference, testing::StartsWith("#"));
  }
}

TEST_F(Report, GivesEveryIdOnceAndRefersToNoOther) {
  Run("--max-poses 10");
  Expect("report s");
  const std::string page = Page();
  const std::vector<std::string> ids = All(page, "[ \n]id=[\"']([^\"']*)");
  const std::set<std::string> unique(ids.begin(), ids.end());
  EXPECT_GT(ids.size(), 50u);
  EXPECT_EQ(ids.size(), unique.size());
  for (const std::string& to : All(page, "(?:href=[\"']|url\\()#([^\"')]*)")) {
    EXPECT_THAT(unique, Contains(to));
  }
}

TEST_F(Report, IsTheSameEveryTime) {
  Run("--max-poses 10");
  Expect("report s --out a.html");
  Expect("report s --out b.html");
  EXPECT_EQ(Page("a.html"), Page("b.html"));
}

TEST_F(Report, ShowsOtherPlansAndMaterialsToo) {
  Run("--plan plan-random.yaml --material retro-cloth.yaml --max-poses 10 --seed 3");
  Expect("report s");
  EXPECT_THAT(
      Missing(Page(), {"retro cloth", "random plan", "seed 3", "error (MALE)", "expected error"}),
      ElementsAre("expected error"));
}

TEST_F(Report, SaysThatTheTruthHasMoved) {
  File("m.yaml", Config("materials/satin-paint.yaml"));
  Run("--material m.yaml --max-poses 10");
  std::filesystem::remove(work() / "m.yaml");
  Expect("report s");
  EXPECT_THAT(Missing(Page(), {"Truth not available: ", "m.yaml", "id=\"slices\"", "error (MALE)"}),
              ElementsAre("error (MALE)"));
  File("m.yaml", Config("materials/glossy-plastic.yaml"));
  Expect("report s");
  EXPECT_THAT(Missing(Page(), {"has changed since the session", "error (MALE)"}),
              ElementsAre("error (MALE)"));
}

TEST_F(Report, ShowsAnInterruptedSessionAsFarAsItGot) {
  const Finished finished = Shell(
      "\"$GONIO\" run --plan plan-grid.yaml --quiet --out s & pid=$!\n"
      "while ! test -s s/session.sqlite-wal; do sleep 0.02; done; sleep 0.3\n"
      "kill -KILL $pid; wait $pid; true");
  ASSERT_EQ(finished.code, 0) << finished.err;
  Expect("report s");
  EXPECT_THAT(Missing(Page(), {"The session has not ended in its log", "id=\"slices\""}),
              IsEmpty());
}

TEST_F(Report, ShowsWhyPosesWereRefusedAndTheSessionFailed) {
  // A camera that cannot expose for less than a second is blinded by a mirror.
  File("rig.yaml", With(Config("sim-rig.yaml"), "min_exposure_s: 20.0e-6", "min_exposure_s: 1"));
  File("mirror.yaml",
       "version: 1\nname: <mirror & co>\nlayers:\n  - kind: ggx\n    roughness: 0.05\n"
       "    f0: [0.9, 0.9, 0.9]\n");
  EXPECT_EQ(Gonio("run --quiet --out s --rig rig.yaml --material mirror.yaml").code, 4);
  Expect("report s");
  EXPECT_THAT(Missing(Page(), {"The session ended early (device fault)", "refused; see the list",
                               "id=\"refused\"", "saturated at the shortest exposure",
                               "&lt;mirror &amp; co&gt;", "<mirror"}),
              ElementsAre("<mirror"));
}

TEST_F(Report, RefusesWhatIsNoSession) {
  ExpectRefused(Gonio("report nowhere"), 2, {"nowhere", "is not a session"});
  std::filesystem::create_directory(work() / "empty");
  ExpectRefused(Gonio("report empty"), 2, {"empty", "is not a session"});
  EXPECT_THAT(Files(), ElementsAre("empty"));
}

TEST_F(Report, SaysWhatToInstallWhenGnuplotIsMissing) {
  Run("--max-poses 3");
  std::filesystem::create_directory(work() / "bin");
  ExpectRefused(Shell("PATH=$PWD/bin \"$GONIO\" report s --out page.html"), 1,
                {"gnuplot not found: apt install gnuplot-nox"});
  EXPECT_THAT(Files(), ElementsAre("bin", "s"));
}

TEST_F(Report, LeavesNothingBehindWhenGnuplotFails) {
  Run("--max-poses 3");
  std::filesystem::create_directory(work() / "bin");
  const auto gnuplot =
      File("bin/gnuplot", "#!/bin/sh\necho '\"-\" line 3: no such font' >&2\nexit 1\n");
  std::filesystem::permissions(gnuplot, std::filesystem::perms::owner_all);
  ExpectRefused(Shell("PATH=$PWD/bin \"$GONIO\" report s --out page.html"), 1,
                {"gnuplot: \"-\" line 3: no such font"});
  File("bin/gnuplot", "#!/bin/sh\nexit 0\n");
  ExpectRefused(Shell("PATH=$PWD/bin \"$GONIO\" report s --out page.html"), 1,
                {"gnuplot: drew no picture"});
  EXPECT_THAT(Files(), ElementsAre("bin", "s"));
}

TEST_F(Report, RefusesAPageThatCannotBeWritten) {
  Run("--max-poses 3");
  ExpectRefused(Gonio("report s --out no/such/folder/page.html"), 1, {"cannot write"});
}

}  // namespace
}  // namespace gonio
