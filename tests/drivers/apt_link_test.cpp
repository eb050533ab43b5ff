// SPDX-License-Identifier: Apache-2.0
// Which message is an answer, and what becomes of the others.
#include "drivers/apt_link.h"

#include <gmock/gmock.h>

#include <deque>

#include "tests/drivers/wire_axis.h"

namespace gonio::apt {
namespace {

using testing::HasSubstr;

std::string Hex(std::initializer_list<int> bytes) {
  std::string text;
  for (const int byte : bytes) text += static_cast<char>(byte);
  return text;
}
// GET_STATUSBITS, with these bits.
std::string Bits(int source, int channel, int bits) {
  return Hex({0x2a, 4, 6, 0, 0x81, source, channel, 0, bits, 0, 0, 0});
}

class AptLink : public testing::Test {
 protected:
  Result<std::string> Asked(const std::string& said) {
    PtyServer line([&](std::string_view) { return said; });
    Link link(OpenedPort(line), kWireReplyLimit);
    const auto answer =
        link.Query(AboutMotor(kReqStatusBits, {.module = 0x21, .channel = 1}), kGetStatusBits);
    if (!answer) return answer.error();
    return *answer->data;
  }
};

// Example failure is a driver of two axes of which one hears the other's position.
TEST_F(AptLink, TakesTheAnswerByKindModuleAndChannel) {
  const auto answer = Asked(Bits(0x22, 1, 7) + Bits(0x21, 2, 7) + Hex({0x64, 4, 1, 0, 1, 0x21}) +
                            Hex({0x91, 4, 1, 0, 1, 0x21}) + Bits(0x21, 1, 5));
  ASSERT_TRUE(answer.ok()) << answer.error().message;
  EXPECT_EQ(*answer, Hex({1, 0, 5, 0, 0, 0}));
}

TEST_F(AptLink, SaysWhatCameInsteadOfAnAnswer) {
  const auto answer = Asked(Hex({0x29, 6, 1, 0, 1, 0x21}));
  ASSERT_FALSE(answer.ok());
  EXPECT_EQ(answer.error().code, ErrorCode::kProtocol);
  EXPECT_THAT(answer.error().message,
              HasSubstr("message 0x0629 came instead of an answer, module 0x21, told "
                        "REQ_STATUSBITS"));
}

TEST_F(AptLink, SaysThatAMessageBrokeOff) {
  const auto answer = Asked(Bits(0x21, 1, 5).substr(0, 11));
  ASSERT_FALSE(answer.ok());
  EXPECT_EQ(answer.error().code, ErrorCode::kProtocol);
  EXPECT_THAT(answer.error().message, HasSubstr("a message that broke off"));
}

TEST_F(AptLink, GivesUpOnADeviceThatTalksNonsense) {
  const auto answer = Asked(std::string(3000, '#'));
  ASSERT_FALSE(answer.ok());
  EXPECT_EQ(answer.error().code, ErrorCode::kProtocol);
  EXPECT_THAT(answer.error().message, HasSubstr("\"######\" is no message of an APT controller"));
}

// Without a checksum or a mark at the beginning of messages there is nothing to go by but silence.
TEST_F(AptLink, FindsItsWayAfterGarbage) {
  int asked = 0;
  PtyServer line([&](std::string_view) {
    ++asked;
    return (asked == 1 ? Hex({0x2a, 4, 6, 0, 0x81, 0x41}) : std::string()) + Bits(0x21, 1, asked);
  });
  Link link(OpenedPort(line), kWireReplyLimit);
  const auto answer =
      link.Query(AboutMotor(kReqStatusBits, {.module = 0x21, .channel = 1}), kGetStatusBits);
  ASSERT_TRUE(answer.ok()) << answer.error().message;
  EXPECT_EQ(*answer->data, Hex({1, 0, 2, 0, 0, 0}));
}

// Says one thing after the other to whoever waits for it, up to an empty one; and from there on
// when it is next asked.
class Chopped final : public ByteLink {
 public:
  explicit Chopped(std::deque<std::string> said) : said_(std::move(said)) {}
  const std::string& name() const override { return name_; }
  Result<void> Write(std::string_view, Seconds) override {
    if (!said_.empty() && said_.front().empty()) said_.pop_front();
    return {};
  }
  Result<std::string> Read(std::size_t, Seconds limit) override {
    if (said_.empty() || said_.front().empty() || limit <= Seconds(0)) {
      return Error{ErrorCode::kTimeout, "no answer"};
    }
    std::string next = std::move(said_.front());
    said_.pop_front();
    return next;
  }
  Result<void> DiscardInput() override { return {}; }

 private:
  std::deque<std::string> said_;
  const std::string name_ = "chopped";
};

TEST_F(AptLink, ThrowsGarbageAwayUntilTheLineIsQuiet) {
  Link link(std::make_unique<Chopped>(std::deque<std::string>{
      "nonsense", "more nonsense", Bits(0x21, 1, 3), "", Bits(0x21, 1, 5)}));
  const auto answer =
      link.Query(AboutMotor(kReqStatusBits, {.module = 0x21, .channel = 1}), kGetStatusBits);
  ASSERT_TRUE(answer.ok()) << answer.error().message;
  EXPECT_EQ(*answer->data, Hex({1, 0, 5, 0, 0, 0}));
}

// Example failure is a driver that throws away what comes right behind an answer.
TEST_F(AptLink, KeepsErrorsThatFollowAnAnswer) {
  Link link(std::make_unique<Chopped>(std::deque<std::string>{
      Bits(0x21, 1, 3) + Hex({0x80, 0, 0, 0, 1, 0x21}), "", Bits(0x21, 1, 5)}));
  const Message question = AboutMotor(kReqStatusBits, {.module = 0x21, .channel = 1});
  for (int i = 0; i < 2; ++i) ASSERT_TRUE(link.Query(question, kGetStatusBits).ok());
  EXPECT_EQ(link.ReportOf(0x21), "its controller reports an error it does not name");
  EXPECT_EQ(link.ReportOf(0x22), "");
  link.Forget(0x21);
  EXPECT_EQ(link.ReportOf(0x21), "");
}

// What is left of a question that was given up.
TEST_F(AptLink, IgnoresWhatCameBeforeItAsked) {
  Link link(std::make_unique<Chopped>(std::deque<std::string>{
      Bits(0x21, 1, 5) + Bits(0x21, 1, 3) + "nonsense", "", Bits(0x21, 1, 7)}));
  const Message question = AboutMotor(kReqStatusBits, {.module = 0x21, .channel = 1});
  ASSERT_TRUE(link.Query(question, kGetStatusBits).ok());
  const auto answer = link.Query(question, kGetStatusBits);
  ASSERT_TRUE(answer.ok()) << answer.error().message;
  EXPECT_EQ(*answer->data, Hex({1, 0, 7, 0, 0, 0}));
}

}  // namespace
}  // namespace gonio::apt
