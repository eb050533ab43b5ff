// SPDX-License-Identifier: Apache-2.0
// Answers of Newport's controllers.
#include <cctype>
#include <cstdio>

#include "core/check.h"
#include "drivers/smc100_codec.h"
#include "tests/fuzz/scripted_link.h"

namespace gonio::smc100 {
namespace {

void CheckStatus(const std::string& answer) {
  const Result<Status> status = DecodeStatus(answer);
  if (!status) return;
  GONIO_CHECK(status->errors <= 0xffff, "errors are four digits");
  char digits[8];
  std::snprintf(digits, sizeof digits, "%04X", status->errors);
  for (int i = 0; i < 4; ++i) {
    GONIO_CHECK(std::toupper(static_cast<unsigned char>(answer[i])) == digits[i],
                "errors are what was sent");
  }
  GONIO_CHECK(TextOf(status->errors).empty() == (status->errors == 0), "errors have words");
}

}  // namespace
}  // namespace gonio::smc100

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string line = gonio::TextOf(data, size);
  gonio::smc100::CheckStatus(line);
  if (size > 0) {
    const std::string text = gonio::smc100::TextOfCommandError(line.front());
    GONIO_CHECK(text.empty() == (line.front() == '@'), "only one letter means nothing");
  }
  for (const char* const command : {"TS", "TP", "VE"}) {
    const auto answer = gonio::smc100::AnswerTo(1, command, line);
    if (!answer) continue;
    GONIO_CHECK(line.substr(line.size() - answer->size()) == *answer && answer->size() + 3 == size,
                "an answer is the rest of its line");
    gonio::smc100::CheckStatus(*answer);
  }
  return 0;
}
