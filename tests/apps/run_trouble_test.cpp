// SPDX-License-Identifier: Apache-2.0
// What a user sees when a session is not left alone: interlocks, notices, parking.

#include <nlohmann/json.hpp>

#include "acquisition/session_record.h"
#include "tests/apps/gonio_process.h"

namespace gonio {
namespace {

using nlohmann::json;
using testing::HasSubstr;

class RunTrouble : public GonioTest {
 protected:
  void Rig(const std::string& more) { File("rig.yaml", Config("sim-rig.yaml") + more); }
};

TEST_F(RunTrouble, AnEmergencyStopIsSaidAndEndsWithFour) {
  Rig("interlocks:\n  signals:\n"
      "    - {name: button, signal: file, file: button, min: 1, when_tripped: emergency-stop}\n");
  File("button", "0\n");
  const Finished finished = Gonio("run --rig rig.yaml --max-poses 3 --out s --quiet");
  EXPECT_EQ(finished.code, 4);
  EXPECT_THAT(finished.err, HasSubstr("gonio: interlock button: is 0, must be >= 1"));
  EXPECT_EQ(ReadSession(work() / "s").end->outcome, "emergency stop");
  EXPECT_EQ(json::parse(ReadTextFile(work() / "s/status.json"))["state"], "emergency stop");
  // Once it is released the session is begun anew by going on with it.
  File("button", "1\n");
  EXPECT_EQ(Gonio("run --resume s --quiet").code, 0);
  EXPECT_EQ(ReadSession(work() / "s").poses.size(), 3u);
  Expect("report s");
  const std::string page = ReadTextFile(work() / "s/report.html");
  for (const char* word : {"What came between", "interlock button: is 0, must be &gt;= 1",
                           "goes on in another process", "2 things came between the poses"}) {
    EXPECT_THAT(page, HasSubstr(word));
  }
}

TEST_F(RunTrouble, TheEndIsToldToACommand) {
  EXPECT_EQ(Gonio("run --max-poses 3 --out s --quiet --notify 'cat > notice'").code, 0);
  const json notice = json::parse(ReadTextFile(work() / "notice"));
  EXPECT_EQ(notice["kind"], "session_end");
  EXPECT_THAT(notice["message"], HasSubstr("complete: "));
  EXPECT_TRUE(std::filesystem::equivalent(notice["session"].get<std::string>(), work() / "s"));
}

// Example failure is a night that ends because a mail could not be sent.
TEST_F(RunTrouble, ACommandThatFailsIsSaidAndHarmsNothing) {
  const Finished finished = Gonio("run --max-poses 3 --out s --quiet --notify 'exit 7'");
  EXPECT_EQ(finished.code, 0);
  EXPECT_THAT(finished.err, HasSubstr("gonio: warning: --notify exit 7: it ended with 7"));
}

TEST_F(RunTrouble, ArmsAreParked) {
  ExpectRefused(Gonio("run --park --max-poses 3 --out s"), 2,
                {"--park: the rig file has no motion.park_deg"});
  Rig("");
  const std::string park =
      "  park_deg: {light_azimuth: 0, light_elevation: 80, camera_azimuth: 180, camera_elevation: "
      "80}\n";
  File("rig.yaml", With(Config("sim-rig.yaml"), "motion:\n", "motion:\n" + park));
  EXPECT_EQ(Gonio("run --rig rig.yaml --park --max-poses 3 --out s --quiet").code, 0);
  bool parked = false;
  for (const SessionEvent& event : ReadSession(work() / "s").events) {
    parked = parked || event.kind == "parked";
  }
  EXPECT_TRUE(parked);
  File("rig.yaml", With(Config("sim-rig.yaml"), "motion:\n",
                        "motion:\n" + With(park, "light_elevation: 80", "light_elevation: 95")));
  ExpectRefused(Gonio("run --rig rig.yaml --park --max-poses 3 --out t"), 2,
                {"motion.park_deg.light_elevation"});
}

}  // namespace
}  // namespace gonio
