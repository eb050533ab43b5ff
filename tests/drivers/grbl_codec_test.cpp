// SPDX-License-Identifier: Apache-2.0
#include "drivers/grbl_codec.h"

#include <gmock/gmock.h>

namespace gonio::grbl {
namespace {

using testing::ElementsAre;
using testing::IsEmpty;

// Lines are those of Grbl's documentation, not ours.
Message Decoded(std::string_view line) {
  const auto message = Decode(line);
  EXPECT_TRUE(message.ok()) << line;
  return message.ok() ? *message : Message{};
}

TEST(GrblDecode, ReadsAnswers) {
  EXPECT_EQ(Decoded("ok").kind, Kind::kOk);
  EXPECT_EQ(Decoded("error:15").kind, Kind::kError);
  EXPECT_EQ(Decoded("error:15").code, 15);
  EXPECT_EQ(Decoded("ALARM:9").kind, Kind::kAlarm);
  EXPECT_EQ(Decoded("ALARM:9").code, 9);
}

TEST(GrblDecode, ReadsReports) {
  const Message message = Decoded("<Idle|MPos:0.000,-10.000,5.000|FS:0.0,0>");
  EXPECT_EQ(message.kind, Kind::kReport);
  EXPECT_EQ(message.report.state, State::kIdle);
  EXPECT_THAT(message.report.position, ElementsAre(0, -10, 5));
  EXPECT_FALSE(message.report.work);
  EXPECT_THAT(message.report.offset, IsEmpty());
}

// Example failure is a decoder that knows the order in which one version prints its fields.
TEST(GrblDecode, ReadsFieldsInAnyOrderAndPassesOverOthers) {
  const Report report =
      Decoded(
          "<Hold:1|Ov:100,100,100|WCO:0.000,1.551,5.664|Pn:XYZ|WPos:-2.500,0.000,11.000|F:500"
          "|Bf:15,128|Ln:99999|A:SFM>")
          .report;
  EXPECT_EQ(report.state, State::kHold);
  EXPECT_EQ(report.detail, 1);
  EXPECT_TRUE(report.work);
  EXPECT_THAT(report.position, ElementsAre(-2.5, 0, 11));
  EXPECT_THAT(report.offset, ElementsAre(0, 1.551, 5.664));
  EXPECT_THAT(Decoded("<Jog|MPos:1,2,3,4>").report.position, ElementsAre(1, 2, 3, 4));
}

TEST(GrblDecode, KnowsAllStates) {
  const State states[] = {State::kIdle, State::kRun,   State::kHold, State::kJog,  State::kAlarm,
                          State::kDoor, State::kCheck, State::kHome, State::kSleep};
  const char* const names[] = {"Idle",   "Run",   "Hold:0", "Jog",  "Alarm",
                               "Door:3", "Check", "Home",   "Sleep"};
  for (int i = 0; i < 9; ++i) {
    EXPECT_EQ(Decoded(std::string("<") + names[i] + "|MPos:0,0,0|FS:0,0>").report.state, states[i]);
  }
}

TEST(GrblDecode, ReadsWhatComesUnasked) {
  EXPECT_EQ(Decoded("Grbl 1.1h ['$' for help]").kind, Kind::kWelcome);
  EXPECT_EQ(Decoded("Grbl 1.1h ['$' for help]").text, "1.1h");
  EXPECT_EQ(Decoded("[MSG:'$H'|'$X' to unlock]").text, "MSG:'$H'|'$X' to unlock");
  EXPECT_EQ(Decoded("[VER:1.1d.20161014:Some string]").text, "VER:1.1d.20161014:Some string");
  for (const char* const line : {"", ">G54G20:ok", ">:error:7", "$N0=G54", "[echo:G1X0.540]"}) {
    EXPECT_EQ(Decoded(line).kind, Kind::kNote) << line;
  }
}

TEST(GrblDecode, ReadsSettings) {
  const Message message = Decoded("$110=500.000");
  EXPECT_EQ(message.kind, Kind::kSetting);
  EXPECT_EQ(message.code, 110);
  EXPECT_EQ(message.text, "500.000");
}

TEST(GrblDecode, RefusesWhatIsNoLineOfGrbls) {
  for (const char* const line : {"oi",
                                 "OK",
                                 "ok ",
                                 "error:",
                                 "error:x",
                                 "error:1000",
                                 "error:-1",
                                 "ALARM: Hard limit",
                                 "$",
                                 "$=",
                                 "$x=1",
                                 "$110=",
                                 "[",
                                 "[MSG",
                                 "<",
                                 "<>",
                                 "<Idle>",
                                 "<Kdle|MPos:0,0,0>",
                                 "<Idle|MPos:0,0,0",
                                 "<Idle|MPos:>",
                                 "<Idle|MPos:1,x,2>",
                                 "<Idle|MPos:1,2,inf>",
                                 "<Idle|MPos:1,2,3|WCO:a>",
                                 "<Hold:x|MPos:1,2,3>",
                                 "<Idle|MPos:1,2,3,4,5,6,7,8,9>",
                                 "@01 1 OK IDLE -- 0",
                                 "1TP0.5",
                                 "\xff\xfe"}) {
    EXPECT_FALSE(Decode(line).ok()) << line;
  }
  EXPECT_EQ(Decode("\xfe\x02k").error().message, "\"\\xfe\\x02k\" is not a line of Grbl's");
}

TEST(GrblEncode, JogsInTheMachinesCoordinates) {
  Leg leg;
  leg.target[0] = -12.5;
  leg.feed = 600;
  EXPECT_EQ(Encode(leg), "$J=G21G53X-12.5000F600.000");
  leg.target = {-359.99999, {}, -1, -0.00012};
  leg.feed = 1e-9;
  EXPECT_EQ(Encode(leg), "$J=G21G53X-360.0000Z-1.0000A-0.0001F0.001");
  leg.target.fill(-999999.9);
  leg.feed = 999999;
  EXPECT_LE(Encode(leg).size(), 79u);
}

TEST(GrblText, SaysWhatCodesMean) {
  EXPECT_EQ(TextOfError(15), "error 15, beyond the travel of the axis");
  EXPECT_EQ(TextOfError(999), "error 999");
  EXPECT_EQ(TextOfAlarm(1), "alarm 1, hard limit: a switch stopped it");
  EXPECT_EQ(TextOfAlarm(77), "alarm 77");
  EXPECT_EQ(TextOf(State::kDoor), "waiting for its safety door");
}

}  // namespace
}  // namespace gonio::grbl
