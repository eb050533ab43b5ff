// SPDX-License-Identifier: Apache-2.0
// gonio check.
#include <nlohmann/json.hpp>

#include "tests/apps/gonio_process.h"

namespace gonio {
namespace {

using testing::HasSubstr;

class Check : public GonioTest {};

TEST_F(Check, SaysWhichPosesAreLeftAndWhoIsToBlame) {
  const auto all = nlohmann::json::parse(Expect("check sim-rig.yaml --json -").out);
  const auto solid = nlohmann::json::parse(Expect("check rig-solid-arms.yaml --json -").out);
  ASSERT_EQ(all.size(), solid.size());
  for (std::size_t i = 0; i < all.size(); ++i) {
    EXPECT_EQ(all[i]["keep_out"], 0);
    EXPECT_GT(solid[i]["keep_out"], 50);
    EXPECT_EQ(solid[i]["keep_out_by"]["light_arm 1, camera_arm 1"], solid[i]["keep_out"]);
    EXPECT_EQ(solid[i]["measurable"].get<int>() + solid[i]["keep_out"].get<int>(),
              all[i]["measurable"]);
  }
}

TEST_F(Check, DrawsThem) {
  EXPECT_THAT(Expect("check rig-solid-arms.yaml --out reach.svg").out,
              HasSubstr("wrote            reach.svg"));
  EXPECT_TRUE(std::filesystem::exists(work() / "reach.svg"));
  ExpectRefused(Gonio("check rig-solid-arms.yaml --out reach.jpg"), 2, {"reach.jpg"});
}

// Example failure is a rig whose arms stand in each other's way once they are homed.
TEST_F(Check, ItsRigMeasures) {
  const Finished finished = Expect("run --rig rig-solid-arms.yaml --max-poses 12 --quiet --out s");
  EXPECT_THAT(finished.out, HasSubstr("12 measured"));
  EXPECT_THAT(finished.out, HasSubstr("0 refused"));
}

TEST_F(Check, RefusesARigThatIsNone) {
  File("rig.yaml", "version: 1\n");
  ExpectRefused(Gonio("check rig.yaml"), 2, {"rig.yaml:1: name: is missing"});
}

}  // namespace
}  // namespace gonio
