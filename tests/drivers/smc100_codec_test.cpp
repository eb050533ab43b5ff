// SPDX-License-Identifier: Apache-2.0
#include "drivers/smc100_codec.h"

#include <gtest/gtest.h>

namespace gonio::smc100 {
namespace {

TEST(Smc100Encode, PutsTheAddressBefore) {
  EXPECT_EQ(Encode(1, "PA12.5"), "1PA12.5\r\n");
  EXPECT_EQ(Encode(31, "TS"), "31TS\r\n");
}

TEST(Smc100AnswerTo, TakesTheEchoOff) {
  EXPECT_EQ(*AnswerTo(1, "TP", "1TP-0.123"), "-0.123");
  EXPECT_EQ(*AnswerTo(12, "TE", "12TE@"), "@");
}

TEST(Smc100AnswerTo, RefusesTheAnswerToAnotherQuestion) {
  const auto other = AnswerTo(1, "TP", "1TS000028");
  ASSERT_FALSE(other.ok());
  EXPECT_EQ(other.error().code, ErrorCode::kProtocol);
  EXPECT_EQ(other.error().message, "\"1TS000028\" does not answer 1TP");
  EXPECT_FALSE(AnswerTo(2, "TP", "1TP3").ok());
  EXPECT_FALSE(AnswerTo(1, "TP", "").ok());
}

TEST(Smc100Status, KnowsItsStates) {
  const auto state_of = [](std::string_view answer) { return DecodeStatus(answer)->state; };
  EXPECT_EQ(state_of("000028"), State::kMoving);
  EXPECT_EQ(state_of("00000A"), State::kNotReferenced);
  EXPECT_EQ(state_of("000011"), State::kNotReferenced);
  EXPECT_EQ(state_of("000014"), State::kConfiguration);
  EXPECT_EQ(state_of("00001E"), State::kHoming);
  EXPECT_EQ(state_of("000032"), State::kReady);
  EXPECT_EQ(state_of("000035"), State::kReady);
  EXPECT_EQ(state_of("00003c"), State::kDisabled);
  EXPECT_EQ(state_of("000047"), State::kJogging);
}

TEST(Smc100Status, SpellsItsErrorsOut) {
  EXPECT_EQ(DecodeStatus("002028")->errors, 0x20u);
  EXPECT_EQ(TextOf(0), "");
  EXPECT_EQ(TextOf(0x22), "positive end of run, following error");
  EXPECT_EQ(TextOf(0x1001), "negative end of run, error 1000");
}

TEST(Smc100Status, RefusesWhatIsNone) {
  for (const char* answer : {"", "28", "000099", "00002G", "0000028", "-00028"}) {
    const auto status = DecodeStatus(answer);
    ASSERT_FALSE(status.ok()) << answer;
    EXPECT_EQ(status.error().code, ErrorCode::kProtocol);
  }
}

TEST(Smc100CommandError, SpellsLettersOut) {
  EXPECT_EQ(TextOfCommandError('@'), "");
  EXPECT_EQ(TextOfCommandError('H'), "not allowed while not referenced");
  EXPECT_EQ(TextOfCommandError('N'), "position outside the soft limits");
  EXPECT_EQ(TextOfCommandError('\x01'), "error \"\\x01\"");
}

}  // namespace
}  // namespace gonio::smc100
