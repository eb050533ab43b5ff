// SPDX-License-Identifier: Apache-2.0
#include "drivers/scpi.h"

#include <gmock/gmock.h>

#include <deque>
#include <string>
#include <utility>
#include <vector>

namespace gonio::scpi {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

constexpr const char* kIdentity = "Maker,Model,123,1.0";
constexpr const char* kNoError = "0,\"No error\"";

// What a device does next: answers, or an error of the link; and what it was told.
struct Script {
  std::deque<Result<std::string>> reads;
  std::vector<std::string> told;
  int clears = 0;

  void Answer(const std::string& answer) { reads.push_back(answer + "\n"); }
  void Fail(ErrorCode code) { reads.push_back(Error{code, "link: failed"}); }
};

class ScriptedLink final : public MessageLink {
 public:
  explicit ScriptedLink(Script* script) : script_(script) {}
  const std::string& name() const override { return name_; }
  Result<void> Write(std::string_view message, Seconds) override {
    script_->told.emplace_back(message);
    return {};
  }
  Result<std::string> Read(Seconds) override {
    if (script_->reads.empty()) return Error{ErrorCode::kTimeout, "link: no answer"};
    auto next = std::move(script_->reads.front());
    script_->reads.pop_front();
    return next;
  }
  Result<void> Clear() override {
    ++script_->clears;
    return {};
  }

 private:
  Script* const script_;
  const std::string name_ = "link";
};

class Scpi : public testing::Test {
 protected:
  void SetUp() override {
    script_.Answer(kIdentity);
    auto opened = Instrument::Open(std::make_unique<ScriptedLink>(&script_));
    ASSERT_TRUE(opened.ok()) << opened.error().message;
    instrument_ = std::move(opened).value();
    EXPECT_THAT(script_.told, ElementsAre("*IDN?\n"));
    script_.told.clear();
    script_.clears = 0;
  }

  Script script_;
  std::unique_ptr<Instrument> instrument_;
};

TEST_F(Scpi, AsksForTextAndNumbers) {
  EXPECT_EQ(instrument_->identity(), kIdentity);
  script_.Answer("ON");
  EXPECT_EQ(*instrument_->Query("A?"), "ON");
  for (const auto& [text, number] : std::vector<std::pair<std::string, double>>{
           {"7.5E-04", 7.5e-4}, {"+1.25", 1.25}, {"-3", -3}, {"0", 0}}) {
    script_.Answer(text);
    EXPECT_EQ(*instrument_->Number("B?"), number);
  }
  EXPECT_EQ(script_.told.front(), "A?\n");
  EXPECT_EQ(script_.clears, 0);
}

// Example failure is a level that is the answer to the question before.
TEST_F(Scpi, NeverTakesALateAnswerForAnothers) {
  script_.Fail(ErrorCode::kTimeout);
  script_.Answer("1.5");  // late
  script_.Answer(kIdentity);
  script_.Answer("2.5");
  EXPECT_EQ(*instrument_->Number("A?"), 2.5);
  EXPECT_EQ(script_.clears, 1);
  EXPECT_THAT(script_.told, ElementsAre("A?\n", "*IDN?\n", "A?\n"));
  // Neither for that to the same question, asked once.
  script_.Fail(ErrorCode::kTimeout);
  EXPECT_EQ(instrument_->Number("SLOW?", Seconds(1)).error().code, ErrorCode::kTimeout);
  script_.Answer("1.5");
  script_.Answer(kIdentity);
  script_.Answer("3.5");
  EXPECT_EQ(*instrument_->Number("SLOW?", Seconds(1)), 3.5);
}

TEST_F(Scpi, AsksTwiceAndNotMoreOften) {
  script_.Answer("garbage");
  script_.Answer(kIdentity);
  script_.Answer("1e999");
  const auto number = instrument_->Number("A?");
  ASSERT_FALSE(number.ok());
  EXPECT_EQ(number.error().code, ErrorCode::kProtocol);
  EXPECT_EQ(number.error().message, "link: the answer is \"1e999\", not a number, asked \"A?\"");
  EXPECT_THAT(script_.told, ElementsAre("A?\n", "*IDN?\n", "A?\n"));
}

TEST_F(Scpi, DoesNotAskAgainWhereTheCableIsOut) {
  script_.Fail(ErrorCode::kDisconnected);
  EXPECT_EQ(instrument_->Number("A?").error().code, ErrorCode::kDisconnected);
  EXPECT_THAT(script_.told, ElementsAre("A?\n"));
}

TEST_F(Scpi, CommandsAreSentOnceAndTheirErrorsAskedFor) {
  script_.Answer(kNoError);
  script_.Answer("+0,\"No error\"");
  EXPECT_TRUE(instrument_->Command("SET 1").ok());
  EXPECT_THAT(script_.told, ElementsAre("SYST:ERR?\n", "SET 1\n", "SYST:ERR?\n"));
  script_.told.clear();
  script_.Answer("-310,\"left over\"");
  script_.Answer(kNoError);
  script_.Answer("-113,\"Undefined header\"");
  script_.Answer("-222,\"Data out of range\"");
  script_.Answer(kNoError);
  const auto refused = instrument_->Command("SET 2");
  ASSERT_FALSE(refused.ok());
  EXPECT_EQ(refused.error().code, ErrorCode::kRefused);
  EXPECT_EQ(refused.error().message,
            "link: refused \"SET 2\": -113,\"Undefined header\"; -222,\"Data out of range\"");
  script_.Answer(kNoError);
  script_.Fail(ErrorCode::kTimeout);
  EXPECT_EQ(instrument_->Command("SET 3").error().code, ErrorCode::kTimeout);
  EXPECT_EQ(std::count(script_.told.begin(), script_.told.end(), "SET 3\n"), 1);
}

TEST_F(Scpi, ErrorsWithoutEndAreNonsense) {
  for (int i = 0; i < 100; ++i) script_.Answer("-1,\"again\"");
  const auto refused = instrument_->Command("SET 1");
  ASSERT_FALSE(refused.ok());
  EXPECT_EQ(refused.error().code, ErrorCode::kProtocol);
  EXPECT_THAT(refused.error().message, HasSubstr("errors without end"));
}

TEST(ScpiOpen, RefusesWhatDoesNotSayWhoItIs) {
  Script script;
  for (int i = 0; i < 100; ++i) script.Answer("1.5");
  const auto opened = Instrument::Open(std::make_unique<ScriptedLink>(&script));
  ASSERT_FALSE(opened.ok());
  EXPECT_EQ(opened.error().code, ErrorCode::kProtocol);
  EXPECT_EQ(opened.error().message, "link: \"1.5\" does not say who it is");
  script.reads.clear();
  EXPECT_EQ(Instrument::Open(std::make_unique<ScriptedLink>(&script)).error().message,
            "link: no answer, asked \"*IDN?\"");
}

}  // namespace
}  // namespace gonio::scpi
