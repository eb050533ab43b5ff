// SPDX-License-Identifier: Apache-2.0
// The real libusb, on devices that umockdev pretends to.
#include "drivers/usbtmc.h"

#include <gmock/gmock.h>
#include <sys/stat.h>
#include <unistd.h>

#include <chrono>
#include <future>
#include <thread>

#include "tests/usb/usb_instrument.h"

namespace gonio {
namespace {

using testing::HasSubstr;

constexpr int kProduct = 0x8078;

std::string InBrackets(std::string_view message) {
  return std::string("<").append(message).append(">");
}

// Says after whoever speaks, but to questions that have answers of their own.
std::string Echo(std::string_view message) {
  if (message == "quiet") return {};
  if (message == "long") return std::string(10000, 'x');
  // With the line end and twelve bytes of header this fills two packets of 64 bytes.
  if (message == "full") return std::string(2 * 64 - 12 - 1, 'y');
  if (message == "huge") return std::string(UsbtmcDevice::kMostBytes + 1, 'z');
  return InBrackets(message);
}

class Usbtmc : public testing::Test {
 protected:
  void SetUp() override {
    bench_.Plug(&instrument_);
    device_ = OpenedDevice(plate_);
    ASSERT_NE(device_, nullptr);
  }
  // The answer, or what went wrong.
  std::string Ask(const std::string& message, Seconds limit = kLongLimit) {
    const auto sent = device_->Write(message + "\n", limit);
    if (!sent) return Failed(sent.error());
    const auto answer = device_->Read(limit);
    if (!answer) return Failed(answer.error());
    return answer->size() < 100000 ? *answer : "a very long answer";
  }
  static std::string Failed(const Error& error) {
    return std::string(ToString(error.code)) + ": " + error.message;
  }

  const UsbPlate plate_ = PlateOf(kProduct, "P0012345");
  UsbtmcEmulator instrument_{plate_, Echo};
  UsbBench bench_;
  std::unique_ptr<UsbtmcDevice> device_;
};

// Promise 1.

TEST_F(Usbtmc, AsksAndIsAnswered) {
  EXPECT_EQ(device_->name(), "USB 1313:8078 P0012345");
  EXPECT_TRUE(device_->capabilities().scpi);
  EXPECT_TRUE(device_->capabilities().is_488_2);
  EXPECT_FALSE(device_->capabilities().trigger);
  for (int i = 0; i < 300; ++i) {  // once around the tags
    ASSERT_EQ(Ask(std::to_string(i)), InBrackets(std::to_string(i)) + "\n");
  }
}

TEST_F(Usbtmc, CarriesMessagesOfAnyLength) {
  EXPECT_EQ(Ask("long"), std::string(10000, 'x') + "\n");
  EXPECT_EQ(Ask("full"), std::string(2 * 64 - 12 - 1, 'y') + "\n");
  EXPECT_EQ(Ask("a"), "<a>\n");
  const std::string message(20000, 'm');
  EXPECT_EQ(Ask(message), InBrackets(message) + "\n");
  EXPECT_EQ(instrument_.longest(), message.size() + 1);
  for (const std::size_t size : {1, 2, 3, 4, 51, 52, 4095, 4096, 4097}) {
    const std::string some(size, 's');
    EXPECT_EQ(Ask(some), InBrackets(some) + "\n");
  }
}

// Example failure is a driver that collects until memory is full.
TEST_F(Usbtmc, RefusesAnswersWithoutEnd) {
  EXPECT_EQ(Ask("huge"),
            "protocol: USB 1313:8078 P0012345: 1048576 bytes and no end of the answer");
  EXPECT_EQ(Ask("a"), "<a>\n");
  instrument_.Inject(UsbtmcFault::kNeverEnds, 1 << 30);
  EXPECT_THAT(Ask("abcdef", kShortLimit), HasSubstr("timeout: "));
  instrument_.Inject(UsbtmcFault::kNeverEnds, 0);
  EXPECT_EQ(Ask("a"), "<a>\n");
}

TEST_F(Usbtmc, PutsPiecesTogether) {
  instrument_.Inject(UsbtmcFault::kNoEnd);
  EXPECT_EQ(Ask("in two transfers"), "<in two transfers>\n");
  instrument_.Inject(UsbtmcFault::kHeaderFirst);
  EXPECT_EQ(Ask("header first"), "<header first>\n");
  instrument_.Inject(UsbtmcFault::kEmptyFirst);
  EXPECT_EQ(Ask("nothing first"), "<nothing first>\n");
  EXPECT_EQ(instrument_.aborts() + instrument_.clears(), 0);
}

// Promise 2. Example failure is a driver after whose first time-out every question times out.

TEST_F(Usbtmc, SilenceIsATimeoutAndTheNextQuestionIsAnswered) {
  instrument_.Inject(UsbtmcFault::kSilent);
  EXPECT_EQ(Ask("a", kShortLimit), "timeout: USB 1313:8078 P0012345: no answer within 0.25 s");
  EXPECT_EQ(instrument_.aborts(), 1);
  EXPECT_EQ(instrument_.clears(), 0);
  EXPECT_EQ(Ask("b"), "<b>\n");
}

TEST_F(Usbtmc, ADeviceThatRefusesAbortsIsCleared) {
  instrument_.set_refuses_aborts(true);
  instrument_.Inject(UsbtmcFault::kSilent);
  EXPECT_THAT(Ask("a", kShortLimit), HasSubstr("timeout: "));
  EXPECT_EQ(instrument_.clears(), 1);
  EXPECT_EQ(Ask("b"), "<b>\n");
}

TEST_F(Usbtmc, AQuestionThatHasNoAnswerIsATimeout) {
  EXPECT_THAT(Ask("quiet", kShortLimit), HasSubstr("timeout: "));
  EXPECT_EQ(Ask("b"), "<b>\n");
}

TEST_F(Usbtmc, AnAnswerThatStopsHalfwayIsATimeout) {
  instrument_.Inject(UsbtmcFault::kShort);
  EXPECT_THAT(Ask("a", kShortLimit), HasSubstr("timeout: "));
  EXPECT_EQ(Ask("b"), "<b>\n");
}

TEST_F(Usbtmc, WhatMakesNoSenseIsSaidAndClearedAway) {
  instrument_.Inject(UsbtmcFault::kWrongTag);
  EXPECT_THAT(Ask("a"), HasSubstr("protocol: USB 1313:8078 P0012345: transfer"));
  EXPECT_EQ(Ask("b"), "<b>\n");
  instrument_.Inject(UsbtmcFault::kOversize);
  EXPECT_EQ(Ask("a"),
            "protocol: USB 1313:8078 P0012345: a transfer of 4294967295 bytes was announced, 4096 "
            "were asked for");
  EXPECT_EQ(Ask("b"), "<b>\n");
  EXPECT_EQ(instrument_.clears(), 2);
}

TEST_F(Usbtmc, StalledPipesAreFreed) {
  instrument_.Inject(UsbtmcFault::kStallIn);
  EXPECT_EQ(Ask("a"), "protocol: USB 1313:8078 P0012345: no answer: the endpoint is stalled");
  EXPECT_EQ(Ask("b"), "<b>\n");
  instrument_.Inject(UsbtmcFault::kStallOut);
  EXPECT_EQ(Ask("a"),
            "protocol: USB 1313:8078 P0012345: not all bytes were taken: the endpoint is stalled");
  EXPECT_EQ(Ask("b"), "<b>\n");
}

TEST_F(Usbtmc, ClearingForgetsWhatWasAsked) {
  ASSERT_TRUE(device_->Write("never fetched\n", kLongLimit).ok());
  ASSERT_TRUE(device_->Clear().ok());
  EXPECT_EQ(Ask("b"), "<b>\n");
}

// Promise 3.

TEST_F(Usbtmc, StaysDisconnectedUntilOpenedAgain) {
  bench_.Unplug(&instrument_);
  for (int i = 0; i < 2; ++i) {
    const auto sent = device_->Write("a\n", kLongLimit);
    ASSERT_FALSE(sent.ok());
    EXPECT_EQ(Failed(sent.error()), "disconnected: USB 1313:8078 P0012345: disconnected");
    EXPECT_EQ(device_->Read(kLongLimit).error().code, ErrorCode::kDisconnected);
    EXPECT_EQ(device_->Clear().error().code, ErrorCode::kDisconnected);
    if (i == 0) bench_.Plug(&instrument_);
  }
  device_ = OpenedDevice(plate_);
  EXPECT_EQ(Ask("b"), "<b>\n");
}

TEST_F(Usbtmc, NoticesAtOnceThatTheCableIsOut) {
  instrument_.Inject(UsbtmcFault::kSilent);
  auto asking = std::async(std::launch::async, [&] { return Ask("a"); });
  // Until the message is in, and the answer waited for.
  while (instrument_.longest() == 0) std::this_thread::yield();
  bench_.Unplug(&instrument_);
  EXPECT_EQ(asking.get(), "disconnected: USB 1313:8078 P0012345: disconnected");
}

TEST_F(Usbtmc, GivesTheInterfaceBackToTheSystem) {
  EXPECT_FALSE(bench_.HeldBySystem(&instrument_));
  device_.reset();
  EXPECT_TRUE(bench_.HeldBySystem(&instrument_));
}

// Opening.

std::string WhyNot(const UsbSelection& selection) {
  const auto device = UsbtmcDevice::Open(selection);
  if (device.ok()) return "opened";
  EXPECT_EQ(device.error().code, ErrorCode::kRefused);
  return device.error().message;
}

TEST_F(Usbtmc, BelongsToOneOwner) {
  const UsbSelection same = {.vendor = kThorlabsVendor, .products = {kProduct}, .serial = {}};
  EXPECT_EQ(WhyNot(same), "USB 1313:8078 P0012345: in use by another program");
  device_.reset();
  EXPECT_EQ(WhyNot(same), "opened");
}

TEST_F(Usbtmc, SaysWhichOnesThereAreInstead) {
  EXPECT_EQ(
      WhyNot({.vendor = 0x1234, .products = {0x80c8, 0x80c0}, .serial = {}}),
      "USB 1234:80c8 or 1234:80c0: not plugged in; USB test and measurement devices that are: "
      "USB 1313:8078 P0012345");
  EXPECT_EQ(WhyNot({.vendor = kThorlabsVendor, .products = {kProduct}, .serial = "P7"}),
            "USB 1313:8078 P7: not plugged in; USB test and measurement devices that are: USB "
            "1313:8078 P0012345");
  bench_.Unplug(&instrument_);
  EXPECT_EQ(WhyNot({.vendor = kThorlabsVendor, .products = {kProduct}, .serial = {}}),
            "USB 1313:8078: not plugged in; USB test and measurement devices that are: none");
}

TEST_F(Usbtmc, AsksWhichOfSeveral) {
  UsbtmcEmulator second(PlateOf(kProduct, "P0099999"), Echo);
  bench_.Plug(&second);
  EXPECT_EQ(WhyNot({.vendor = kThorlabsVendor, .products = {kProduct}, .serial = {}}),
            "USB 1313:8078: several are plugged in: USB 1313:8078 P0012345, USB 1313:8078 "
            "P0099999; say which by its serial number");
  EXPECT_EQ(WhyNot({.vendor = kThorlabsVendor, .products = {kProduct}, .serial = "P0099999"}),
            "opened");
  const auto all = ListUsbtmcDevices();
  ASSERT_TRUE(all.ok());
  ASSERT_EQ(all->size(), 2u);
  EXPECT_EQ((*all)[1].vendor, kThorlabsVendor);
  EXPECT_EQ((*all)[1].product, kProduct);
  EXPECT_EQ((*all)[1].serial, "P0099999");
  EXPECT_EQ((*all)[1].description, "Instrument");
  bench_.Unplug(&second);
}

// Example failure is "not found" where the rules of udev are missing.
TEST_F(Usbtmc, NamesTheRuleThatGivesPermission) {
  device_.reset();
  const std::string node = bench_.NodeFile(&instrument_);
  ASSERT_EQ(chmod(node.c_str(), 0), 0);
  constexpr uid_t kNobody = 65534;
  const bool root = geteuid() == 0;
  // The bench itself is for everybody, like the system's own directories.
  const std::size_t end = node.find("/dev/");
  const std::string bench = node.substr(0, end);
  ASSERT_EQ(chmod(bench.c_str(), 0777), 0);
  ASSERT_EQ(chmod((bench + "/ioctl" + node.substr(end)).c_str(), 0777), 0);
  ASSERT_TRUE(!root || seteuid(kNobody) == 0);
  const std::string some =
      WhyNot({.vendor = kThorlabsVendor, .products = {kProduct}, .serial = {}});
  const std::string named =
      WhyNot({.vendor = kThorlabsVendor, .products = {kProduct}, .serial = "P0012345"});
  const auto listed = ListUsbtmcDevices();
  ASSERT_TRUE(!root || seteuid(0) == 0);
  EXPECT_THAT(some, HasSubstr("USB 1313:8078: no permission; copy 60-goniopilot.rules into "));
  EXPECT_EQ(named, some);
  ASSERT_TRUE(listed.ok());
  ASSERT_EQ(listed->size(), 1u);
  EXPECT_EQ((*listed)[0].product, kProduct);
  EXPECT_EQ((*listed)[0].serial, "");
}

}  // namespace
}  // namespace gonio
