// SPDX-License-Identifier: Apache-2.0
#include "drivers/zaber_codec.h"

#include <gtest/gtest.h>

namespace gonio::zaber {
namespace {

// From other programs that talk to such devices, not from ours.
TEST(ZaberChecksum, MatchesKnownLines) {
  EXPECT_EQ(Checksum("get maxspeed"), "49");
  EXPECT_EQ(Checksum("2 0 5 get maxspeed"), "52");
  EXPECT_EQ(Checksum("01 tools echo"), "8F");
  EXPECT_EQ(Checksum("1 1 home"), "B5");
  EXPECT_EQ(Checksum("1 1 move abs 10000"), "40");
  EXPECT_EQ(Checksum("01 1 OK IDLE -- 0"), "8C");
}

TEST(ZaberEncode, AddressesDeviceAndAxis) {
  EXPECT_EQ(Encode({.device = 1, .axis = 1, .id = {}, .data = "home"}), "/01 1 home:85\n");
  EXPECT_EQ(Encode({.device = 12, .axis = 0, .id = 5, .data = "get pos"}).substr(0, 15),
            "/12 0 5 get pos");
  EXPECT_EQ(Encode({}), "/00 0:50\n");  // of all, their status
}

TEST(ZaberDecode, ReadsAReply) {
  const auto message = Decode("@01 1 OK IDLE -- 0:8C");
  ASSERT_TRUE(message.ok()) << message.error().message;
  EXPECT_EQ(message->kind, Kind::kReply);
  EXPECT_EQ(message->device, 1);
  EXPECT_EQ(message->axis, 1);
  EXPECT_FALSE(message->id.has_value());
  EXPECT_TRUE(message->accepted);
  EXPECT_FALSE(message->busy);
  EXPECT_EQ(message->warning, "");
  EXPECT_EQ(message->data, "0");
}

TEST(ZaberDecode, ReadsARejectionWithIdAndWarning) {
  const auto message = Decode("@03 2 217 RJ BUSY WR BADCOMMAND");
  ASSERT_TRUE(message.ok()) << message.error().message;
  EXPECT_EQ(message->id, 217);
  EXPECT_FALSE(message->accepted);
  EXPECT_TRUE(message->busy);
  EXPECT_EQ(message->warning, "WR");
  EXPECT_EQ(message->data, "BADCOMMAND");
}

TEST(ZaberDecode, ReadsInfoAndAlerts) {
  const auto info = Decode("#01 0 7 cont 1 of a long one\\");
  ASSERT_TRUE(info.ok());
  EXPECT_EQ(info->kind, Kind::kInfo);
  EXPECT_EQ(info->id, 7);
  EXPECT_EQ(info->data, "cont 1 of a long one");
  EXPECT_TRUE(info->continued);
  const auto alert = Decode("!01 1 IDLE FS");
  ASSERT_TRUE(alert.ok());
  EXPECT_EQ(alert->kind, Kind::kAlert);
  EXPECT_EQ(alert->warning, "FS");
  EXPECT_EQ(alert->data, "");
}

TEST(ZaberDecode, RefusesWhatIsNoMessage) {
  const auto message_of = [](std::string_view line) {
    const auto message = Decode(line);
    return message.ok() ? "understood" : message.error().message;
  };
  EXPECT_EQ(message_of(""), "\"\" is not a message of a Zaber device");
  EXPECT_EQ(message_of("1.25"), "\"1.25\" is not a message of a Zaber device");
  EXPECT_EQ(message_of("@01 1 OK IDLE -- 1:8C"), "\"@01 1 OK IDLE -- 1:8C\" has a wrong checksum");
  EXPECT_EQ(message_of("@0x 1 OK IDLE -- 0"),
            "\"@0x 1 OK IDLE -- 0\" does not say from which device and axis it is");
  EXPECT_EQ(message_of("@01 1 OK IDLE"), "\"@01 1 OK IDLE\" has no status where one is due");
  EXPECT_EQ(message_of("@01 1 \xff"), "\"@01 1 \\xff\" has no status where one is due");
  EXPECT_EQ(Decode("@").error().code, ErrorCode::kProtocol);
}

}  // namespace
}  // namespace gonio::zaber
