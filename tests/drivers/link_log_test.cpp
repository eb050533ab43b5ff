// SPDX-License-Identifier: Apache-2.0
#include "drivers/link_log.h"

#include <gmock/gmock.h>

#include "core/file.h"
#include "tests/core/temp_dir.h"

namespace gonio {
namespace {

// Answers what it was sent, once; then it is gone.
class Echo final : public ByteLink {
 public:
  const std::string& name() const override { return name_; }
  Result<void> Write(std::string_view bytes, Seconds) override {
    bytes_ = bytes;
    return {};
  }
  Result<std::string> Read(std::size_t, Seconds) override {
    if (bytes_.empty()) return Error{ErrorCode::kDisconnected, "echo: disconnected"};
    return std::exchange(bytes_, {});
  }
  Result<void> DiscardInput() override { return {}; }

 private:
  const std::string name_ = "echo";
  std::string bytes_;
};

class LinkLogTest : public testing::Test {
 protected:
  ManualClock clock_;
  std::shared_ptr<LinkLog> log_ = std::make_shared<LinkLog>(&clock_);
  std::unique_ptr<ByteLink> link_ = Logged(std::make_unique<Echo>(), log_);
};

TEST_F(LinkLogTest, KeepsEveryByteAsItCame) {
  clock_.SleepFor(Seconds(1.5));
  ASSERT_TRUE(link_->Write(std::string("a\n\xff\0", 4), Seconds(1)).ok());
  ASSERT_TRUE(link_->Read(10, Seconds(1)).ok());
  EXPECT_FALSE(link_->Read(10, Seconds(1)).ok());
  EXPECT_EQ(log_->Last(9),
            "    1.500000 echo > \"a\\x0a\\xff\\x00\"\n"
            "    1.500000 echo < \"a\\x0a\\xff\\x00\"\n"
            "    1.500000 echo ! echo: disconnected\n");
  EXPECT_EQ(log_->Last(1), "    1.500000 echo ! echo: disconnected\n");
  const LinkLog::Count count = log_->Counts().at("echo");
  EXPECT_EQ(count.sent, 1);
  EXPECT_EQ(count.bytes_sent, 4);
  EXPECT_EQ(count.bytes_received, 4);
  EXPECT_EQ(count.failures, 1);
}

// Example failure is a log that begins with the first pose, when the stage was set up wrong before.
TEST_F(LinkLogTest, WritesWhatCameBeforeItHadAFile) {
  const TempDir dir;
  (void)link_->Write("before", Seconds(1));
  log_->WriteTo(dir / "wire.log");
  (void)link_->Write(std::string(500, 'x'), Seconds(1));
  EXPECT_EQ(ReadTextFile(dir / "wire.log"), log_->Last(9));
  EXPECT_THAT(log_->Last(9), testing::HasSubstr(std::string(500, 'x')));
}

TEST_F(LinkLogTest, ForgetsWhatIsLongAgo) {
  for (std::size_t i = 0; i < LinkLog::kKept + 5; ++i) log_->Sent("echo", std::to_string(i));
  const std::string all = log_->Last(2 * LinkLog::kKept);
  EXPECT_EQ(std::count(all.begin(), all.end(), '\n'), static_cast<long>(LinkLog::kKept));
  EXPECT_EQ(log_->Counts().at("echo").sent, static_cast<long>(LinkLog::kKept) + 5);
}

}  // namespace
}  // namespace gonio
