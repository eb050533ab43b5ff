// SPDX-License-Identifier: Apache-2.0
#include "drivers/gcs2_codec.h"

#include <gtest/gtest.h>

namespace gonio::gcs2 {
namespace {

TEST(Gcs2Encode, EndsWithALineFeedOrNot) {
  EXPECT_EQ(Encode(0, "MOV 1 10.5"), "MOV 1 10.5\n");
  EXPECT_EQ(Encode(2, "POS? 1"), "2 POS? 1\n");
  EXPECT_EQ(Encode(0, kMotionStatus), "\x05");
  EXPECT_EQ(Encode(0, kIsReady), "\x07");
  EXPECT_EQ(Encode(0, kStopAll), "\x18");
  EXPECT_EQ(Encode(3, kStopAll), "3 \x18");
  EXPECT_EQ(Shown(kStopAll), "#24");
  EXPECT_EQ(Shown("ERR?"), "ERR?");
}

TEST(Gcs2Line, IsTheLastWithoutABlank) {
  EXPECT_FALSE(IsLastLine("1=10.5 "));
  EXPECT_TRUE(IsLastLine("2=11.5"));
  EXPECT_TRUE(IsLastLine(""));
}

TEST(Gcs2Line, SaysWhichControllerItIsFrom) {
  EXPECT_EQ(*FromController(0, "1=3"), "1=3");
  EXPECT_EQ(*FromController(2, "0 2 1=3"), "1=3");
  EXPECT_EQ(*FromController(2, "0 2 "), "");
  for (const char* other : {"0 1 1=3", "1=3", "0 21 1=3", ""}) {
    EXPECT_EQ(FromController(2, other).error().code, ErrorCode::kProtocol) << other;
  }
}

TEST(Gcs2Identity, IsTakenForNothingElse) {
  EXPECT_TRUE(IsIdentity("(c)2015 Physik Instrumente (PI) GmbH & Co. KG, C-863.11, 0, 1.2"));
  EXPECT_TRUE(IsIdentity("0 1 (c)2007 PHYSIK INSTRUMENTE(PI) Karlsruhe, E-861"));
  for (const char* other : {"", "1=1", "Physik", "THORLABS,PM100D,P0001,2.4.0"}) {
    EXPECT_FALSE(IsIdentity(other)) << other;
  }
}

TEST(Gcs2Value, BelongsToItsAxis) {
  EXPECT_EQ(*NumberOf("1=10.500000", "1"), 10.5);
  EXPECT_EQ(*NumberOf("A=-1.5e-3 ", "A"), -1.5e-3);
  EXPECT_TRUE(*FlagOf("1=1", "1"));
  EXPECT_FALSE(*FlagOf("1= 0", "1"));
  for (const char* other : {"", "1", "=1", "2=1", "11=1", "1=", "1=1=1", "1=2", "1=1.5", "1 1"}) {
    EXPECT_EQ(FlagOf(other, "1").error().code, ErrorCode::kProtocol) << other;
  }
  EXPECT_FALSE(NumberOf("1=inf", "1").ok());
  EXPECT_FALSE(NumberOf("1=1e999", "1").ok());
  EXPECT_EQ(NumberOf("2=1", "1").error().message, "\"2=1\" is nothing of 1");
}

TEST(Gcs2Moving, IsHexadecimal) {
  EXPECT_EQ(*MovingIn("0"), 0u);
  EXPECT_EQ(*MovingIn("1A"), 0x1au);
  for (const char* other : {"", "G", "-1", "0x1", "100000000", "1=1"}) {
    EXPECT_EQ(MovingIn(other).error().code, ErrorCode::kProtocol) << other;
  }
}

TEST(Gcs2Ready, IsAByteThatIsNoLetter) {
  EXPECT_TRUE(*ReadyIn("\xb1"));
  EXPECT_FALSE(*ReadyIn("\xb0"));
  for (const char* other : {"", "1", "\xb1\xb1", "\xb2"})
    EXPECT_FALSE(ReadyIn(other).ok()) << other;
}

TEST(Gcs2Unit, IsWhatFollows) {
  EXPECT_EQ(*UnitIn("1 0x07000601=DEG"), "DEG");
  EXPECT_FALSE(UnitIn("DEG").ok());
  EXPECT_TRUE(IsDegrees("DEG"));
  EXPECT_TRUE(IsDegrees("deg"));
  for (const char* other : {"", "DE", "MM", "RAD"}) EXPECT_FALSE(IsDegrees(other)) << other;
}

TEST(Gcs2Error, IsANumber) {
  EXPECT_EQ(*ErrorIn("0"), 0);
  EXPECT_EQ(*ErrorIn("-1024"), -1024);
  EXPECT_EQ(*ErrorIn(" 7 "), 7);
  for (const char* other : {"", "1=1", "5.0", "99999999999", "\x08"}) {
    EXPECT_EQ(ErrorIn(other).error().code, ErrorCode::kProtocol) << other;
  }
}

TEST(Gcs2Error, IsSpelledOut) {
  EXPECT_EQ(TextOf(5), "not referenced, or servo off");
  EXPECT_EQ(TextOf(7), "position out of limits");
  EXPECT_EQ(TextOf(8), "velocity out of limits");
  EXPECT_EQ(TextOf(15), "no such axis");
  EXPECT_EQ(TextOf(4711), "error 4711");
}

// Example failure is a driver that fails because its own stop was obeyed.
TEST(Gcs2Error, IsNoneIfSomebodyStoppedIt) {
  EXPECT_FALSE(IsError(0));
  EXPECT_FALSE(IsError(10));
  EXPECT_TRUE(IsError(5));
  EXPECT_TRUE(IsError(-1024));
}

TEST(Gcs2Error, IsAFaultIfItHappenedByItself) {
  for (const int fault : {-1024, 45, 216, 4711}) EXPECT_TRUE(IsFault(fault)) << fault;
  for (const int other : {0, 1, 2, 5, 7, 8, 10, 15, 17}) EXPECT_FALSE(IsFault(other)) << other;
}

}  // namespace
}  // namespace gonio::gcs2
