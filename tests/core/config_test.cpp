// SPDX-License-Identifier: Apache-2.0
#include "core/config.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/error.h"
#include "tests/core/temp_dir.h"

namespace gonio {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

ConfigNode Rig(const std::string& text) { return ConfigNode::Parse(text, "rig.yaml"); }

// The complaint about `text` when `read` is applied to its root.
template <typename Read>
std::string Complaint(const std::string& text, const Read& read) {
  return MessageOf<ConfigError>([&] { read(Rig(text)); });
}

TEST(ConfigNode, ReadsEveryKindOfValue) {
  const ConfigNode root =
      Rig("speed: 2.5\ncount: 3\non: true\nname: stage one\nkind: fast\nlist: [1, 2.5]\n"
          "axes:\n  tilt: {max_deg: 80}\nlamps:\n  - {id: 1}\n  - {id: 2}\n");
  EXPECT_EQ(root.Number("speed"), 2.5);
  EXPECT_EQ(root.Integer("count"), 3);
  EXPECT_TRUE(root.BoolOr("on", false));
  EXPECT_EQ(root.Text("name"), "stage one");
  EXPECT_EQ(root.Choice("kind", {"slow", "fast"}), "fast");
  EXPECT_THAT(root.Numbers("list"), ElementsAre(1, 2.5));
  EXPECT_EQ(root.Map("axes").Map("tilt").Number("max_deg"), 80);
  const auto lamps = root.MapList("lamps");
  ASSERT_EQ(lamps.size(), 2u);
  EXPECT_EQ(lamps[0].Integer("id"), 1);
  EXPECT_EQ(lamps[1].Integer("id"), 2);
  EXPECT_NO_THROW(root.RefuseUnknownKeys());
}

TEST(ConfigNode, FallsBackOnlyWhereAKeyIsAbsent) {
  const ConfigNode root = Rig("a: 1\n");
  EXPECT_EQ(root.NumberOr("a", 7), 1);
  EXPECT_EQ(root.NumberOr("b", 7), 7);
  EXPECT_EQ(root.IntegerOr("b", 8), 8);
  EXPECT_TRUE(root.BoolOr("b", true));
  EXPECT_EQ(root.TextOr("b", "none"), "none");
}

TEST(ConfigNode, NamesFileLineAndFullKey) {
  EXPECT_EQ(Complaint("x: 1\naxes:\n  tilt:\n    max_speed_deg_s: -5\n",
                      [](const ConfigNode& root) {
                        root.Map("axes").Map("tilt").Number("max_speed_deg_s", Range::Positive());
                      }),
            "rig.yaml:4: axes.tilt.max_speed_deg_s: is -5, must be > 0");
  EXPECT_EQ(Complaint("lamps:\n  - id: 1\n  - id: x\n",
                      [](const ConfigNode& root) { root.MapList("lamps")[1].Integer("id"); }),
            "rig.yaml:3: lamps[1].id: is \"x\", must be a finite number");
}

struct BadNumber {
  const char* text;
  Range range;
  const char* complaint;
};

class ConfigNodeNumber : public testing::TestWithParam<BadNumber> {};

TEST_P(ConfigNodeNumber, IsRefusedWithItsReason) {
  EXPECT_EQ(Complaint(std::string("a: ") + GetParam().text,
                      [](const ConfigNode& root) { root.Number("a", GetParam().range); }),
            std::string("rig.yaml:1: a: ") + GetParam().complaint);
}

INSTANTIATE_TEST_SUITE_P(
    Bad, ConfigNodeNumber,
    testing::Values(BadNumber{"abc", Range::Any(), "is \"abc\", must be a finite number"},
                    BadNumber{"1 2", Range::Any(), "is \"1 2\", must be a finite number"},
                    BadNumber{".nan", Range::Any(), "is \".nan\", must be a finite number"},
                    BadNumber{".inf", Range::Any(), "is \".inf\", must be a finite number"},
                    BadNumber{"1e999", Range::Any(), "is \"1e999\", must be a finite number"},
                    BadNumber{"", Range::Any(), "is missing"},
                    BadNumber{"[1]", Range::Any(), "must be a single value"},
                    BadNumber{"0", Range::Positive(), "is 0, must be > 0"},
                    BadNumber{"-1", Range::NonNegative(), "is -1, must be >= 0"},
                    BadNumber{"91", Range::Between(0, 90), "is 91, must be between 0 and 90"},
                    BadNumber{"5", Range{.max = 4}, "is 5, must be <= 4"},
                    BadNumber{"0", Range{.min = 0, .max = 90, .min_open = true},
                              "is 0, must be > 0 and <= 90"}));

TEST(ConfigNode, AcceptsTheEndsOfARange) {
  EXPECT_EQ(Rig("a: 0").Number("a", Range::NonNegative()), 0);
  EXPECT_EQ(Rig("a: 0").Number("a", Range::Between(0, 90)), 0);
  EXPECT_EQ(Rig("a: 90").Number("a", Range::Between(0, 90)), 90);
}

TEST(ConfigNode, RefusesABrokenWholeNumber) {
  const auto read = [](const ConfigNode& root) { root.Integer("a", 1, 9); };
  EXPECT_EQ(Complaint("a: 1.5", read), "rig.yaml:1: a: is 1.5, must be a whole number");
  EXPECT_EQ(Complaint("a: 10", read), "rig.yaml:1: a: is 10, must be between 1 and 9");
  const auto open_ended = [](const ConfigNode& root) { root.Integer("a", 1); };
  EXPECT_EQ(Complaint("a: 0", open_ended), "rig.yaml:1: a: is 0, must be >= 1");
  EXPECT_EQ(Complaint("a: 3000000000", open_ended), "rig.yaml:1: a: is 3000000000, too large");
}

TEST(ConfigNode, RefusesEverythingButTrueAndFalse) {
  EXPECT_FALSE(Rig("a: false").BoolOr("a", true));
  EXPECT_EQ(Complaint("a: yes", [](const ConfigNode& root) { root.BoolOr("a", true); }),
            "rig.yaml:1: a: is \"yes\", must be true or false");
}

TEST(ConfigNode, ListsWhatCanBeChosen) {
  EXPECT_EQ(Complaint("a: z",
                      [](const ConfigNode& root) {
                        root.Choice("a", {"x", "y"});
                      }),
            "rig.yaml:1: a: is \"z\", must be one of x, y");
}

TEST(ConfigNode, RefusesListsOfTheWrongShape) {
  const auto read = [](const ConfigNode& root) { root.Numbers("a", 3, Range::Between(0, 1)); };
  EXPECT_EQ(Complaint("a: [0, 1]", read), "rig.yaml:1: a: must be a list of 3 numbers");
  EXPECT_EQ(Complaint("a: 5", read), "rig.yaml:1: a: must be a list of 3 numbers");
  EXPECT_EQ(Complaint("a: [0, 1, 2]", read), "rig.yaml:1: a: holds 2, must be between 0 and 1");
  EXPECT_EQ(Complaint("a: [0, 1, x]", read),
            "rig.yaml:1: a: holds something that is not a finite number");
  EXPECT_EQ(Complaint("a: []", [](const ConfigNode& root) { root.Numbers("a"); }),
            "rig.yaml:1: a: must be a list of numbers");
}

TEST(ConfigNode, ReadsListsOfWords) {
  EXPECT_THAT(Rig("a: [x, y z]").Texts("a"), ElementsAre("x", "y z"));
  EXPECT_THAT(Rig("a: []").Texts("a"), testing::IsEmpty());
}

TEST(ConfigNode, RefusesMappingsOfTheWrongShape) {
  EXPECT_EQ(Complaint("a: 5", [](const ConfigNode& root) { root.Map("a"); }),
            "rig.yaml:1: a: must hold keys and values");
  EXPECT_EQ(Complaint("a: []", [](const ConfigNode& root) { root.MapList("a"); }),
            "rig.yaml:1: a: must be a list that is not empty");
  EXPECT_EQ(Complaint("a:\n  - {b: 1}\n  - 7", [](const ConfigNode& root) { root.MapList("a"); }),
            "rig.yaml:3: a: entries must hold keys and values");
}

TEST(ConfigNode, NamesAMissingKey) {
  EXPECT_EQ(Complaint("b: 1\nc: {}\n", [](const ConfigNode& root) { root.Number("a"); }),
            "rig.yaml:1: a: is missing");
  EXPECT_EQ(
      Complaint("b: 1\nc:\n  d: 1\n", [](const ConfigNode& root) { root.Map("c").Text("e"); }),
      "rig.yaml:3: c.e: is missing");
}

TEST(ConfigNode, RefusesAKeyThatNobodyAskedFor) {
  EXPECT_EQ(Complaint("a: 1\nspede: 2\n",
                      [](const ConfigNode& root) {
                        root.Number("a");
                        root.RefuseUnknownKeys();
                      }),
            "rig.yaml:2: spede: is not a known key");
}

TEST(ConfigNode, RefusesUnknownKeysInTheMappingsThatWereOpened) {
  EXPECT_EQ(Complaint("a:\n  b: 1\n  c: 2\n",
                      [](const ConfigNode& root) {
                        root.Map("a").Number("b");
                        root.RefuseUnknownKeys();
                      }),
            "rig.yaml:3: a.c: is not a known key");
  EXPECT_EQ(Complaint("a:\n  - b: 1\n  - c: 2\n",
                      [](const ConfigNode& root) {
                        for (const ConfigNode& item : root.MapList("a")) item.Has("b");
                        root.RefuseUnknownKeys();
                      }),
            "rig.yaml:3: a[1].c: is not a known key");
}

TEST(ConfigNode, RemembersWhatWasReadThroughEarlierHandles) {
  const ConfigNode root = Rig("a:\n  b: 1\n  c: 2\n");
  root.Map("a").Number("b");
  root.Map("a").Number("c");
  EXPECT_NO_THROW(root.RefuseUnknownKeys());
}

TEST(ConfigNode, RefusesAKeyThatStandsTwice) {
  EXPECT_EQ(Complaint("a: 1\nb: 2\na: 3\n", [](const ConfigNode&) {}),
            "rig.yaml:3: a: stands twice");
  EXPECT_EQ(Complaint("x:\n  - {c: 1}\n  - {c: 1, c: 2}\n", [](const ConfigNode&) {}),
            "rig.yaml:3: c: stands twice");
}

TEST(ConfigNode, RefusesWhatIsNotAMapping) {
  const std::string complaint = "rig.yaml:1: must hold keys and values (\"key: value\")";
  for (const char* text : {"", "# nothing\n", "just words", "- 1\n- 2\n", "~"}) {
    EXPECT_EQ(Complaint(text, [](const ConfigNode&) {}), complaint) << text;
  }
}

TEST(ConfigNode, RefusesBrokenYamlWithItsLine) {
  EXPECT_THAT(Complaint("a: 1\nb: [1, 2\n", [](const ConfigNode&) {}),
              testing::StartsWith("rig.yaml:3: not valid YAML: "));
  EXPECT_THAT(Complaint("a: 1\n\tb: 2\n", [](const ConfigNode&) {}), HasSubstr("not valid YAML: "));
}

TEST(ConfigNode, RefusesASecondDocumentInsteadOfForgettingIt) {
  EXPECT_EQ(Complaint("a: 1\n---\nb: 2\n", [](const ConfigNode&) {}),
            "rig.yaml:3: must hold one YAML document, not 2");
}

TEST(ConfigNode, RefusesAliasesThatContainThemselves) {
  EXPECT_THAT(Complaint("a: &loop [1, *loop]\n", [](const ConfigNode&) {}),
              HasSubstr("rig.yaml:1: "));
}

TEST(ConfigNode, LoadsAFileAndNamesItInComplaints) {
  const TempDir dir;
  const auto path = dir.File("plan.yaml", "a: 1\n");
  EXPECT_EQ(ConfigNode::Load(path).Number("a"), 1);
  EXPECT_EQ(MessageOf<ConfigError>([&] { ConfigNode::Load(path).Number("b"); }),
            path.string() + ":1: b: is missing");
  EXPECT_THAT(MessageOf<ConfigError>([&] { ConfigNode::Load(dir / "no.yaml"); }),
              HasSubstr("no.yaml: cannot read: No such file"));
}

TEST(ConfigNode, LetsTheCallerComplainAtAKey) {
  EXPECT_EQ(Complaint("a: 1\nb: 2\n", [](const ConfigNode& root) { root.Fail("b", "clashes"); }),
            "rig.yaml:2: b: clashes");
}

TEST(ConfigNode, SaysWhereItIs) {
  const ConfigNode root = Rig("a: 1\nb:\n  c: {d: 1}\n");
  EXPECT_EQ(root.Where(), "rig.yaml:1");
  EXPECT_EQ(root.Map("b").Map("c").Where(), "rig.yaml:3: b.c");
}

TEST(ConfigNode, ListsItsKeysInOrder) {
  EXPECT_THAT(Rig("b: 1\na: 2\n").Keys(), ElementsAre("b", "a"));
}

}  // namespace
}  // namespace gonio
