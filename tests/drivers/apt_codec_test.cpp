// SPDX-License-Identifier: Apache-2.0
#include "drivers/apt_codec.h"

#include <gmock/gmock.h>

#include "drivers/apt_stages.h"

namespace gonio::apt {
namespace {

using testing::HasSubstr;

// "53 04" as two bytes.
std::string Bytes(const std::string& hex) {
  std::string bytes;
  for (std::size_t i = 0; i + 1 < hex.size(); i += 3) {
    bytes += static_cast<char>(std::stoi(hex.substr(i, 2), nullptr, 16));
  }
  return bytes;
}
Message Taken(const std::string& hex) {
  std::string bytes = Bytes(hex);
  const auto message = TakeMessage(&bytes);
  EXPECT_TRUE(message.ok() && message->has_value() && bytes.empty()) << hex;
  return **message;
}

TEST(AptEncode, WritesTheManualsExample) {
  EXPECT_EQ(Encode(MoveTo({.module = 0x22, .channel = 1}, 200000)),
            Bytes("53 04 06 00 A2 01 01 00 40 0D 03 00"));
}

TEST(AptEncode, WritesWhatOtherProgramsWrite) {
  EXPECT_EQ(Encode(AboutMotor(kMoveHome, {})), Bytes("43 04 01 00 50 01"));
  EXPECT_EQ(Encode(MoveTo({}, 19196)), Bytes("53 04 06 00 D0 01 01 00 FC 4A 00 00"));
  EXPECT_EQ(Encode(MoveTo({}, 6144000)), Bytes("53 04 06 00 D0 01 01 00 00 C0 5D 00"));
  EXPECT_EQ(Encode(MoveTo({}, -1)), Bytes("53 04 06 00 D0 01 01 00 FF FF FF FF"));
}

TEST(AptEncode, PutsParametersInTheirOrder) {
  EXPECT_EQ(Encode(AboutMotor(kMoveStop, {.module = 0x50, .channel = 1}, 2)),
            Bytes("65 04 01 02 50 01"));
  EXPECT_EQ(Encode(SetVelocity(0x50, {.channel = 1, .least = 0, .acceleration = 2, .most = 3})),
            Bytes("13 04 0E 00 D0 01 01 00 00 00 00 00 02 00 00 00 03 00 00 00"));
  EXPECT_EQ(Encode(SetBacklash(0x50, {.channel = 1, .distance = 0})),
            Bytes("3A 04 06 00 D0 01 01 00 00 00 00 00"));
}

TEST(AptTakeMessage, TellsMessagesWithDataByTheTopBitOfTheirDestination) {
  const Message homed = Taken("44 04 01 00 01 50");
  EXPECT_EQ(homed.id, kMoveHomed);
  EXPECT_EQ(homed.source, 0x50);
  EXPECT_FALSE(homed.data.has_value());
  EXPECT_EQ(ChannelOf(homed), 1);
  const Message status = Taken("2A 04 06 00 81 22 02 00 00 04 00 80");
  EXPECT_EQ(status.source, 0x22);
  EXPECT_EQ(status.data->size(), 6u);
  EXPECT_EQ(ChannelOf(status), 2);
}

TEST(AptTakeMessage, TakesOneAfterTheOtherHoweverTheyArrive) {
  const std::string all = Bytes("44 04 01 00 01 50 3C 04 06 00 81 50 01 00 00 00 00 00");
  std::string bytes;
  std::vector<std::uint16_t> taken;
  for (const char byte : all) {
    bytes += byte;
    const auto message = TakeMessage(&bytes);
    ASSERT_TRUE(message.ok());
    if (*message) taken.push_back((*message)->id);
  }
  EXPECT_THAT(taken, testing::ElementsAre(kMoveHomed, kGetGenMoveParams));
  EXPECT_EQ(bytes, "");
}

TEST(AptTakeMessage, RefusesGarbage) {
  for (const char* hex : {
           "44 04 01 00 02 50",  // to somebody else
           "44 04 01 00 01 60",  // from no controller
           "91 04 00 01 81 50",  // 256 bytes of data
           "FF FF FF FF FF FF",
           "00 00 00 00 00 00",
       }) {
    std::string bytes = Bytes(hex);
    const auto message = TakeMessage(&bytes);
    ASSERT_FALSE(message.ok()) << hex;
    EXPECT_EQ(message.error().code, ErrorCode::kProtocol);
    EXPECT_EQ(bytes, Bytes(hex));
  }
  std::string bytes = "hello, world";
  EXPECT_EQ(TakeMessage(&bytes).error().message, "\"hello,\" is no message of an APT controller");
}

TEST(AptStatus, IsReadFromBothKinds) {
  const auto servo =
      DecodeStatus(Taken("91 04 0E 00 81 50 01 00 FC 4A 00 00 05 00 00 00 10 04 00 80"));
  ASSERT_TRUE(servo.ok());
  EXPECT_EQ(servo->channel, 1);
  EXPECT_EQ(servo->position, 19196);
  EXPECT_EQ(servo->bits, 0x80000410);
  const auto stepper =
      DecodeStatus(Taken("81 04 0E 00 81 50 01 00 FF FF FF FF 07 00 00 00 20 00 00 00"));
  ASSERT_TRUE(stepper.ok());
  EXPECT_EQ(stepper->position, -1);
  EXPECT_EQ(stepper->bits, 0x20u);
}

TEST(AptStatus, RefusesWhatIsNone) {
  const auto shorter = DecodeStatus(Taken("91 04 06 00 81 50 01 00 FC 4A 00 00"));
  ASSERT_FALSE(shorter.ok());
  EXPECT_EQ(shorter.error().code, ErrorCode::kProtocol);
  EXPECT_EQ(shorter.error().message,
            "GET_DCSTATUSUPDATE with 6 bytes of data is no GET_DCSTATUSUPDATE with 14");
  EXPECT_FALSE(DecodeStatus(Taken("91 04 01 00 01 50")).ok());
  EXPECT_FALSE(DecodeStatus(Taken("44 04 01 00 01 50")).ok());
}

TEST(AptStatus, SpellsFaultsOut) {
  EXPECT_EQ(FaultsIn(0x90012500), "");  // what a healthy controller shows
  EXPECT_EQ(FaultsIn(0x1000000), "");
  EXPECT_EQ(FaultsIn(0x4004000), "motion error, over-current");
  EXPECT_EQ(FaultsIn(0x20000 | 0x40000 | 0x80000 | 0x2000000),
            "over-temperature, bus voltage fault, commutation error, encoder fault");
}

TEST(AptParameters, AreReadInTheirOrder) {
  const auto velocity =
      DecodeVelocity(Taken("15 04 0E 00 81 50 01 00 00 00 00 00 02 00 00 00 03 00 00 00"));
  ASSERT_TRUE(velocity.ok());
  EXPECT_EQ(velocity->acceleration, 2);
  EXPECT_EQ(velocity->most, 3);
  const auto backlash = DecodeBacklash(Taken("3C 04 06 00 81 50 01 00 7F 07 00 00"));
  ASSERT_TRUE(backlash.ok());
  EXPECT_EQ(backlash->distance, 1919);
  const auto homing =
      DecodeHoming(Taken("42 04 0E 00 81 50 01 00 02 00 01 00 09 00 00 00 F6 FF FF FF"));
  ASSERT_TRUE(homing.ok());
  EXPECT_EQ(homing->direction, 2);
  EXPECT_EQ(homing->limit_switch, 1);
  EXPECT_EQ(homing->velocity, 9);
  EXPECT_EQ(homing->offset, -10);
  EXPECT_FALSE(DecodeHoming(Taken("42 04 06 00 81 50 01 00 02 00 01 00")).ok());
}

TEST(AptInfo, ReadsWhoItIs) {
  std::string data = Bytes("F9 FC 9B 01") + "KDC101" + std::string(2, '\0') + Bytes("10 00") +
                     Bytes("03 00 02 00");
  data.resize(84, '\0');
  Message message = Taken("06 00 00 00 81 50");
  message.data = data;
  const auto info = DecodeInfo(message);
  ASSERT_TRUE(info.ok());
  EXPECT_EQ(info->serial, 27000057);
  EXPECT_EQ(info->model, "KDC101");
  // The order of the firmware's numbers is not ground truth.
  EXPECT_THAT(info->firmware, HasSubstr("."));
  message.data = data.substr(1);
  EXPECT_FALSE(DecodeInfo(message).ok());
}

TEST(AptReport, SaysWhatWentWrong) {
  EXPECT_EQ(ReportIn(Taken("80 00 00 00 01 50"))->text, "an error it does not name");
  Message rich = Taken("81 00 00 00 81 50");
  rich.data = Bytes("53 04 0A 00") + "too \x01 far" + std::string(55, '\0');
  const auto report = ReportIn(rich);
  ASSERT_TRUE(report.has_value());
  EXPECT_EQ(report->about, kMoveAbsolute);
  EXPECT_EQ(report->text, "error 10: \"too \\x01 far\"");
  EXPECT_FALSE(ReportIn(Taken("44 04 01 00 01 50")).has_value());
}

TEST(AptName, IsTheManuals) {
  EXPECT_EQ(NameOf(0x0453), "MOVE_ABSOLUTE");
  EXPECT_EQ(NameOf(0x0691), "message 0x0691");
}

// The manual's table, in its own rounding.
TEST(AptStages, CountAsTheManualSays) {
  EXPECT_EQ(static_cast<int>(10 * FindStage("PRM1-Z8")->counts_per_degree), 19196);
  EXPECT_NEAR(FindStage("DDR100")->counts_per_degree, 9102.22, 0.005);
  EXPECT_NEAR(FindStage("DDR05")->counts_per_degree, 5555.55, 0.006);
  EXPECT_NEAR(45 * FindStage("K10CR1")->counts_per_degree, 6144000, 0.5);
  EXPECT_NEAR(0.99997 * FindStage("NR360")->counts_per_degree, 75091, 0.5);
  const auto k10cr1 = FindStage("K10CR1");
  EXPECT_NEAR(k10cr1->counts_per_degree / k10cr1->acceleration_per_degree, 90.9, 0.05);
}

TEST(AptStages, RefusesUnknownOnes) {
  const auto stage = FindStage("MTS50");
  ASSERT_FALSE(stage.ok());
  EXPECT_EQ(stage.error().code, ErrorCode::kRefused);
  EXPECT_EQ(stage.error().message,
            "\"MTS50\" is no stage known here; known are PRM1-Z8, DDR100, DDR05, K10CR1, HDR50, "
            "NR360");
}

TEST(AptStages, KnowTheirControllers) {
  const auto why = [](const char* stage, std::int32_t serial, const char* model) {
    return WhyNotDriven(*FindStage(stage), {.serial = serial, .model = model, .firmware = ""});
  };
  EXPECT_EQ(why("PRM1-Z8", 27000001, "KDC101"), "");
  EXPECT_EQ(why("DDR100", 73000001, "BBD102"), "");
  EXPECT_EQ(why("HDR50", 40000001, "BSC201"), "");
  EXPECT_EQ(why("HDR50", -1, "SCC201"), "");
  EXPECT_EQ(why("HDR50", 40000001, "BSC101"),
            "BSC101 with serial number 40000001 makes other steps than a BSC20x, for which the "
            "scale of a HDR50 is known");
  EXPECT_EQ(why("K10CR1", 27000001, "KDC101"),
            "KDC101 with serial number 27000001 does not drive a K10CR1: the number would begin "
            "with one of 55");
}

}  // namespace
}  // namespace gonio::apt
