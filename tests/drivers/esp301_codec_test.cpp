// SPDX-License-Identifier: Apache-2.0
#include "drivers/esp301_codec.h"

#include <gtest/gtest.h>

namespace gonio::esp301 {
namespace {

TEST(Esp301Encode, PutsTheAxisBefore) {
  EXPECT_EQ(Encode(1, "PA12.5"), "1PA12.5\r");
  EXPECT_EQ(Encode(3, "MD?"), "3MD?\r");
  EXPECT_EQ(Encode(0, "TE?"), "TE?\r");
}

TEST(Esp301Line, KnowsWhatItDidNotAskFor) {
  EXPECT_TRUE(IsUnasked("E36, something"));
  EXPECT_FALSE(IsUnasked("ESP301 Version 3.0.1 6/1/99"));
  EXPECT_FALSE(IsUnasked("E"));
  EXPECT_FALSE(IsUnasked("1"));
}

TEST(Esp301Version, IsTakenForNothingElse) {
  EXPECT_TRUE(IsVersion("ESP301 Version 3.0.1 6/1/99"));
  EXPECT_TRUE(IsVersion(" ESP300 Version 3.04"));
  for (const char* other : {"", "ESP", "1.5", "E301", "SMC_CC_1.0.1", "TS50DC.5, SN1263"}) {
    EXPECT_FALSE(IsVersion(other)) << other;
  }
}

TEST(Esp301Flag, IsZeroOrOne) {
  EXPECT_TRUE(*FlagIn("1", "MD?"));
  EXPECT_FALSE(*FlagIn(" 0 ", "MD?"));
  for (const char* other : {"", " ", "2", "10", "1.0", "-1", "+1", "1x", "\x01", "01x"}) {
    const auto flag = FlagIn(other, "MD?");
    ASSERT_FALSE(flag.ok()) << other;
    EXPECT_EQ(flag.error().code, ErrorCode::kProtocol);
  }
  EXPECT_EQ(FlagIn("12.5", "MD?").error().message, "\"12.5\" does not answer MD?");
}

TEST(Esp301Value, IsAFiniteNumber) {
  EXPECT_EQ(*ValueIn("-12.5", "TP?"), -12.5);
  EXPECT_EQ(*ValueIn(" 3 ", "TP?"), 3);
  for (const char* other : {"", "inf", "nan", "1e999", "1 2", "12.5deg"}) {
    EXPECT_EQ(ValueIn(other, "TP?").error().code, ErrorCode::kProtocol) << other;
  }
}

TEST(Esp301Unit, IsSpelledOut) {
  EXPECT_EQ(*UnitIn("7"), kDegrees);
  EXPECT_EQ(TextOfUnit(7), "degrees");
  EXPECT_EQ(TextOfUnit(2), "mm");
  EXPECT_EQ(TextOfUnit(11), "urad");
  EXPECT_EQ(TextOfUnit(-1), "unit -1");
  EXPECT_FALSE(UnitIn("12").ok());
  EXPECT_FALSE(UnitIn("7.5").ok());
}

TEST(Esp301Error, SaysWhoseItIs) {
  EXPECT_EQ(*ErrorIn("0"), (QueuedError{0, 0}));
  EXPECT_TRUE(ErrorIn("0")->none());
  EXPECT_EQ(*ErrorIn("4"), (QueuedError{0, 4}));
  EXPECT_EQ(*ErrorIn("106"), (QueuedError{1, 6}));
  EXPECT_EQ(*ErrorIn("320"), (QueuedError{3, 20}));
  EXPECT_FALSE(ErrorIn("100")->none());
  for (const char* other :
       {"", "-4", "99999999999", "10000", "4.5", "0, 1234, NO ERROR DETECTED"}) {
    EXPECT_EQ(ErrorIn(other).error().code, ErrorCode::kProtocol) << other;
  }
}

TEST(Esp301Error, IsSpelledOut) {
  EXPECT_EQ(TextOf({1, 4}), "positive hardware limit");
  EXPECT_EQ(TextOf({1, 7}), "negative software limit");
  EXPECT_EQ(TextOf({2, 8}), "motor or stage not connected");
  EXPECT_EQ(TextOf({1, 13}), "motor not enabled");
  EXPECT_EQ(TextOf({3, 20}), "homing aborted");
  EXPECT_EQ(TextOf({0, 4}), "emergency stop");
  EXPECT_EQ(TextOf({0, 7}), "parameter out of range");
  EXPECT_EQ(TextOf({0, 9}), "axis number out of range");
  EXPECT_EQ(TextOf({2, 77}), "error 277");
}

// Example failure is a driver that takes a following error for the refusal of its next command.
TEST(Esp301Error, IsAFaultIfItHappenedByItself) {
  for (const QueuedError& fault : {QueuedError{1, 3}, QueuedError{1, 4}, QueuedError{1, 20},
                                   QueuedError{0, 4}, QueuedError{1, 77}}) {
    EXPECT_TRUE(IsFault(fault)) << TextOf(fault);
  }
  for (const QueuedError& refusal : {QueuedError{1, 6}, QueuedError{1, 13}, QueuedError{0, 7}}) {
    EXPECT_FALSE(IsFault(refusal)) << TextOf(refusal);
  }
}

}  // namespace
}  // namespace gonio::esp301
