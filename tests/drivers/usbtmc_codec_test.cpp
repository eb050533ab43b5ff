// SPDX-License-Identifier: Apache-2.0
#include "drivers/usbtmc_codec.h"

#include <gtest/gtest.h>

#include <initializer_list>

namespace gonio::usbtmc {
namespace {

std::string Bytes(std::initializer_list<int> bytes) {
  std::string text;
  for (const int byte : bytes) text += static_cast<char>(byte);
  return text;
}

std::string WhyNot(const std::string& transfer, std::uint8_t tag = 2, std::size_t most = 1024) {
  const auto header = DecodeIn(transfer, tag, most);
  if (header.ok()) return "accepted";
  EXPECT_EQ(header.error().code, ErrorCode::kProtocol);
  return header.error().message;
}

TEST(UsbtmcEncode, PutsAHeaderBeforeAndPadsToFourBytes) {
  EXPECT_EQ(EncodeOut(1, "*IDN?\n", true),
            Bytes({0x01, 0x01, 0xFE, 0x00, 0x06, 0x00, 0x00, 0x00, 0x01, 0x00,
                   0x00, 0x00, 0x2A, 0x49, 0x44, 0x4E, 0x3F, 0x0A, 0x00, 0x00}));
  EXPECT_EQ(EncodeOut(0x80, "abcd", false),
            Bytes({0x01, 0x80, 0x7F, 0, 4, 0, 0, 0, 0, 0, 0, 0, 'a', 'b', 'c', 'd'}));
}

TEST(UsbtmcEncode, AsksForAnAnswer) {
  EXPECT_EQ(EncodeRequestIn(2, 1024),
            Bytes({0x02, 0x02, 0xFD, 0x00, 0x00, 0x04, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00}));
}

TEST(UsbtmcEncode, NeverUsesTagZero) {
  EXPECT_EQ(NextTag(0), 1);
  EXPECT_EQ(NextTag(254), 255);
  EXPECT_EQ(NextTag(255), 1);
}

TEST(UsbtmcDecode, ReadsTheHeaderOfAnAnswer) {
  const auto last = DecodeIn(Bytes({2, 2, 0xFD, 0, 3, 0, 0, 0, 1, 0, 0, 0, '1', '\n'}), 2, 1024);
  ASSERT_TRUE(last.ok());
  EXPECT_EQ(last->bytes, 3u);
  EXPECT_TRUE(last->end_of_message);
  const auto more = DecodeIn(Bytes({2, 0xFF, 0, 0, 0x01, 0x02, 0, 0, 2, 0, 0, 0}), 255, 0x201);
  ASSERT_TRUE(more.ok());
  EXPECT_EQ(more->bytes, 0x201u);
  EXPECT_FALSE(more->end_of_message);
}

TEST(UsbtmcDecode, RefusesWhatAnswersSomethingElse) {
  EXPECT_EQ(WhyNot(""), "\"\" is no header of a transfer");
  EXPECT_EQ(WhyNot(Bytes({2, 2, 0xFD, 0, 3, 0, 0, 0, 1, 0, 0})),
            "\"\\x02\\x02\\xfd\\x00\\x03\\x00\\x00\\x00\\x01\\x00\\x00\" is no header of a "
            "transfer");
  EXPECT_EQ(WhyNot(Bytes({1, 2, 0xFD, 0, 3, 0, 0, 0, 1, 0, 0, 0})),
            "a transfer of kind 1 came, not an answer");
  EXPECT_EQ(WhyNot(Bytes({2, 7, 0xF8, 0, 3, 0, 0, 0, 1, 0, 0, 0})),
            "transfer 7 was answered instead of 2");
  EXPECT_EQ(WhyNot(Bytes({2, 2, 0xFC, 0, 3, 0, 0, 0, 1, 0, 0, 0})),
            "the number of a transfer, 2, is garbled");
  EXPECT_EQ(WhyNot(Bytes({2, 2, 0xFD, 0, 0xFF, 0xFF, 0xFF, 0xFF, 1, 0, 0, 0})),
            "a transfer of 4294967295 bytes was announced, 1024 were asked for");
}

TEST(UsbtmcCapabilities, AreReadBitByBit) {
  std::string reply(24, '\0');
  reply[0] = 1;
  reply[3] = 1;
  reply[4] = 4;
  reply[5] = 1;
  reply[14] = 6;
  reply[15] = 12;
  const auto can = DecodeCapabilities(reply);
  ASSERT_TRUE(can.ok());
  EXPECT_FALSE(can->listen_only);
  EXPECT_FALSE(can->talk_only);
  EXPECT_TRUE(can->indicator_pulse);
  EXPECT_TRUE(can->ends_on_character);
  EXPECT_FALSE(can->trigger);
  EXPECT_TRUE(can->remote_local);
  EXPECT_TRUE(can->is_488_2);
  EXPECT_TRUE(can->service_request);
  EXPECT_TRUE(can->scpi);
  reply[4] = 3;
  EXPECT_TRUE(DecodeCapabilities(reply)->listen_only);
  EXPECT_TRUE(DecodeCapabilities(reply)->talk_only);
  EXPECT_FALSE(DecodeCapabilities(reply.substr(0, 23)).ok());
  reply[0] = static_cast<char>(0x80);
  EXPECT_FALSE(DecodeCapabilities(reply).ok());
}

TEST(UsbtmcStatus, SaysWhetherThereIsMoreToRead) {
  const std::string reply = Bytes({0x02, 0x01, 0, 0, 0, 0, 0, 0});
  const auto check = DecodeStatus(Request::kCheckAbortBulkInStatus, reply);
  ASSERT_TRUE(check.ok());
  EXPECT_EQ(check->status, Status::kPending);
  EXPECT_TRUE(check->more_to_read);
  // The second byte is the tag here.
  const auto abort = DecodeStatus(Request::kInitiateAbortBulkIn, Bytes({0x81, 0x01}));
  ASSERT_TRUE(abort.ok());
  EXPECT_EQ(abort->status, Status::kTransferNotInProgress);
  EXPECT_FALSE(abort->more_to_read);
  EXPECT_STREQ(TextOf(abort->status), "transfer not in progress");
  EXPECT_TRUE(DecodeStatus(Request::kInitiateClear, Bytes({1})).ok());
}

TEST(UsbtmcStatus, RefusesWhatIsNone) {
  EXPECT_FALSE(DecodeStatus(Request::kInitiateClear, "").ok());
  EXPECT_FALSE(DecodeStatus(Request::kCheckClearStatus, Bytes({1})).ok());
  EXPECT_FALSE(DecodeStatus(Request::kCheckClearStatus, Bytes({0, 0})).ok());
  EXPECT_FALSE(DecodeStatus(Request::kCheckClearStatus, Bytes({0x84, 0})).ok());
}

}  // namespace
}  // namespace gonio::usbtmc
