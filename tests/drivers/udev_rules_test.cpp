// SPDX-License-Identifier: Apache-2.0
// That configs/60-goniopilot.rules lets users speak to all instruments that the drivers know.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdio>
#include <regex>
#include <set>
#include <sstream>
#include <string>

#include "core/file.h"
#include "drivers/thorlabs.h"

namespace gonio {
namespace {

using testing::IsSupersetOf;

class UdevRules : public testing::Test {
 protected:
  const std::string text_ = ReadTextFile(GONIO_SOURCE_DIR "/configs/60-goniopilot.rules");
};

std::string Hex(int number) {
  char text[8];
  std::snprintf(text, sizeof text, "%04x", static_cast<unsigned>(number));
  return text;
}

TEST_F(UdevRules, GiveAccessToAllInstruments) {
  EXPECT_NE(text_.find("ATTR{idVendor}!=\"" + Hex(kThorlabsVendor) + "\""), std::string::npos);
  std::set<std::string> listed;
  std::istringstream lines(text_);
  const std::regex rule("^ATTR\\{idProduct\\}==\"([0-9a-f|]+)\", .*TAG\\+=\"uaccess\"$");
  for (std::string line; std::getline(lines, line);) {
    std::smatch match;
    if (!std::regex_match(line, match, rule)) continue;
    std::istringstream products(match[1]);
    for (std::string product; std::getline(products, product, '|');) listed.insert(product);
  }
  std::set<std::string> known;
  for (const int product : kDc2200Products) known.insert(Hex(product));
  for (const int product : kPowerMeterProducts) known.insert(Hex(product));
  EXPECT_EQ(listed, known);
}

// Example failure is a rule with "=" for "==", which udev takes for something else.
TEST_F(UdevRules, AreMadeOfWholeTokens) {
  std::string joined = text_;
  for (std::size_t at = 0; (at = joined.find("\\\n", at)) != std::string::npos;) {
    joined.erase(at, 2);
  }
  const std::regex token(
      "\\s*(((ACTION|SUBSYSTEM|DRIVER|ENV\\{\\w+\\}|ATTRS?\\{id\\w+\\})(==|!=))|"
      "((MODE|GROUP|GOTO|LABEL|ATTR\\{latency_timer\\})=)|((TAG|RUN)\\+=))\"[^\"]*\"");
  std::istringstream lines(joined);
  std::set<std::string> labels;
  std::set<std::string> jumps;
  for (std::string line; std::getline(lines, line);) {
    if (line.empty() || line.front() == '#') continue;
    std::string rest = line;
    while (!rest.empty()) {
      std::smatch match;
      ASSERT_TRUE(std::regex_search(rest, match, token, std::regex_constants::match_continuous))
          << rest;
      const std::string whole = match[0];
      const std::string value = whole.substr(whole.find('"'));
      if (whole.find("LABEL=") != std::string::npos) labels.insert(value);
      if (whole.find("GOTO=") != std::string::npos) jumps.insert(value);
      rest.erase(0, whole.size());
      if (!rest.empty()) {
        ASSERT_EQ(rest.front(), ',') << rest;
        rest.erase(0, 1);
      }
    }
  }
  EXPECT_THAT(labels, IsSupersetOf(jumps));
}

TEST_F(UdevRules, MakeSerialAdaptersPassBytesOnAtOnce) {
  EXPECT_NE(text_.find("DRIVER==\"ftdi_sio\", ATTR{latency_timer}=\"1\""), std::string::npos);
}

}  // namespace
}  // namespace gonio
