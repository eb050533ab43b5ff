// SPDX-License-Identifier: Apache-2.0
// Example failure is a new instrument that only root may open.
#include <fmt/format.h>
#include <gmock/gmock.h>

#include "core/file.h"
#include "drivers/thorlabs.h"

namespace gonio {
namespace {

TEST(UdevRules, NameEveryInstrumentThatIsOpened) {
  const std::string rules =
      ReadTextFile(std::string(GONIO_SOURCE_DIR) + "/configs/60-goniopilot.rules");
  EXPECT_THAT(rules,
              testing::HasSubstr(fmt::format("ATTR{{idVendor}}!=\"{:04x}\"", kThorlabsVendor)));
  for (const auto& products : {kDc2200Products, kPowerMeterProducts}) {
    for (const int product : products) {
      EXPECT_THAT(rules, testing::HasSubstr(fmt::format("ATTR{{idProduct}}==\"{:04x}\"", product)));
    }
  }
}

}  // namespace
}  // namespace gonio
