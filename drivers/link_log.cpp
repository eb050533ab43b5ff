// SPDX-License-Identifier: Apache-2.0
#include "drivers/link_log.h"

#include <fmt/format.h>

#include <utility>

#include "drivers/wire_text.h"

namespace gonio {
namespace {

template <typename T>
Result<T> Noted(Result<T> result, const std::string& link, LinkLog& log) {
  if (!result) log.Failed(link, result.error().message);
  return result;
}

// What came in, or why it did not.
Result<std::string> Received(Result<std::string> bytes, const std::string& link, LinkLog& log) {
  if (bytes) log.Received(link, *bytes);
  return Noted(std::move(bytes), link, log);
}

class LoggedBytes final : public ByteLink {
 public:
  LoggedBytes(std::unique_ptr<ByteLink> link, std::shared_ptr<LinkLog> log)
      : link_(std::move(link)), log_(std::move(log)) {}

  const std::string& name() const override { return link_->name(); }
  Result<void> Write(std::string_view bytes, Seconds limit) override {
    log_->Sent(name(), bytes);
    return Noted(link_->Write(bytes, limit), name(), *log_);
  }
  Result<std::string> Read(std::size_t most, Seconds limit) override {
    Result<std::string> bytes = link_->Read(most, limit);
    // One that only looked whether there is anything has not failed.
    const bool looked = limit <= Seconds(0) && !bytes && bytes.error().code == ErrorCode::kTimeout;
    return looked ? bytes : Received(std::move(bytes), name(), *log_);
  }
  Result<void> DiscardInput() override { return Noted(link_->DiscardInput(), name(), *log_); }

 private:
  const std::unique_ptr<ByteLink> link_;
  const std::shared_ptr<LinkLog> log_;
};

class LoggedMessages final : public MessageLink {
 public:
  LoggedMessages(std::unique_ptr<MessageLink> link, std::shared_ptr<LinkLog> log)
      : link_(std::move(link)), log_(std::move(log)) {}

  const std::string& name() const override { return link_->name(); }
  Result<void> Write(std::string_view message, Seconds limit) override {
    log_->Sent(name(), message);
    return Noted(link_->Write(message, limit), name(), *log_);
  }
  Result<std::string> Read(Seconds limit) override {
    return Received(link_->Read(limit), name(), *log_);
  }
  Result<void> Clear() override { return Noted(link_->Clear(), name(), *log_); }

 private:
  const std::unique_ptr<MessageLink> link_;
  const std::shared_ptr<LinkLog> log_;
};

}  // namespace

void LinkLog::Sent(const std::string& link, std::string_view bytes) {
  const std::lock_guard lock(mutex_);
  Count& count = counts_[link];
  ++count.sent;
  count.bytes_sent += static_cast<long>(bytes.size());
  Add(link, ">", Quoted(bytes, bytes.size()));
}

void LinkLog::Received(const std::string& link, std::string_view bytes) {
  const std::lock_guard lock(mutex_);
  counts_[link].bytes_received += static_cast<long>(bytes.size());
  Add(link, "<", Quoted(bytes, bytes.size()));
}

void LinkLog::Failed(const std::string& link, const std::string& why) {
  const std::lock_guard lock(mutex_);
  ++counts_[link].failures;
  Add(link, "!", why);
}

void LinkLog::Add(const std::string& link, const char* way, const std::string& what) {
  lines_.push_back(fmt::format("{:12.6f} {} {} {}", clock_->Now().count(), link, way, what));
  if (lines_.size() > kKept) lines_.pop_front();
  if (file_.is_open()) file_ << lines_.back() << '\n' << std::flush;
}

void LinkLog::WriteTo(const std::filesystem::path& file) {
  const std::lock_guard lock(mutex_);
  file_.open(file, std::ios::app);  // a session that goes on has one already
  for (const std::string& line : lines_) file_ << line << '\n';
  file_ << std::flush;
}

std::string LinkLog::Last(std::size_t lines) const {
  const std::lock_guard lock(mutex_);
  const std::size_t first = lines_.size() > lines ? lines_.size() - lines : 0;
  std::string text;
  for (std::size_t i = first; i < lines_.size(); ++i) text += lines_[i] + '\n';
  return text;
}

std::map<std::string, LinkLog::Count> LinkLog::Counts() const {
  const std::lock_guard lock(mutex_);
  return counts_;
}

std::unique_ptr<ByteLink> Logged(std::unique_ptr<ByteLink> link, std::shared_ptr<LinkLog> log) {
  return std::make_unique<LoggedBytes>(std::move(link), std::move(log));
}

std::unique_ptr<MessageLink> Logged(std::unique_ptr<MessageLink> link,
                                    std::shared_ptr<LinkLog> log) {
  return std::make_unique<LoggedMessages>(std::move(link), std::move(log));
}

}  // namespace gonio
