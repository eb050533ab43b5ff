// SPDX-License-Identifier: Apache-2.0
#include "drivers/grbl_line.h"

#include <fmt/format.h>

#include <utility>

#include "drivers/asked_twice.h"
#include "drivers/deadline.h"
#include "drivers/wire_text.h"

namespace gonio::grbl {
namespace {

constexpr Seconds kResetTakes{1};       // on top of a reply: it pauses after an alarm
constexpr int kMostHeard = 1000;        // lines at a time
constexpr std::size_t kMostSaid = 200;  // before an "ok": there are some 40 settings
constexpr int kReportsBetweenOffsets = 30;

// Whether steps may have been lost, or nothing is known of them.
bool LosesPosition(int alarm) {
  constexpr int kSoftLimit = 2;
  constexpr int kProbe = 4;
  constexpr int kNoContact = 5;
  return alarm != kSoftLimit && alarm != kProbe && alarm != kNoContact;
}

}  // namespace

Line::Line(std::unique_ptr<ByteLink> link, Seconds reply_limit)
    : link_(std::move(link)), lines_(link_.get()), reply_limit_(reply_limit) {}

Result<Message> Line::Next(Seconds limit) {
  const Result<std::string> line = lines_.Next(limit);
  if (!line) return line.error();
  Result<Message> message = Decode(*line);
  if (!message) {
    return Error{ErrorCode::kProtocol, fmt::format("{}: {}", name(), message.error().message)};
  }
  Take(&message.value());
  return message;
}

void Line::Take(Message* message) {
  const int code = message->code;
  switch (message->kind) {
    case Kind::kOk:
      if (!std::exchange(condition_.homing_, false)) return;
      condition_.homed_ = true;
      condition_.fault_.clear();
      ++condition_.homings_;
      return;
    case Kind::kError:
      if (std::exchange(condition_.homing_, false)) condition_.fault_ = TextOfError(code);
      return;
    case Kind::kAlarm:
      condition_.homing_ = false;
      condition_.blocked_ = code == 1 || code == 2;
      condition_.fault_ = TextOfAlarm(code);
      if (LosesPosition(code)) condition_.homed_ = false;
      return;
    case Kind::kReport:
      return TakeReport(&message->report);
    case Kind::kWelcome:
      condition_.homed_ = condition_.homing_ = condition_.blocked_ = owes_ = false;
      offset_.clear();
      return;
    case Kind::kNote:
      if (message->text == "MSG:Reset to continue") condition_.blocked_ = true;
      return;
    case Kind::kSetting:
      return;
  }
}

// To the machine's coordinates, if their offset is known.
void Line::TakeReport(Report* report) {
  // Without its announcement, which was garbled then.
  if (report->state == State::kAlarm || report->state == State::kSleep) condition_.homed_ = false;
  if (!report->offset.empty()) offset_ = report->offset;
  if (report->work && offset_.size() == report->position.size()) {
    for (std::size_t axis = 0; axis < offset_.size(); ++axis) {
      report->position[axis] += offset_[axis];
    }
    report->work = false;
  }
  if (!report->work) last_ = *report;
}

Result<void> Line::AwaitWelcome(Seconds limit) {
  const Deadline deadline(limit);
  while (true) {
    const Result<Message> message = Next(deadline.Left());
    if (message && message->kind == Kind::kWelcome) return {};
    if (!message && message.error().code != ErrorCode::kProtocol) return message.error();
    if (deadline.Left() <= Seconds(0)) {
      return Error{ErrorCode::kTimeout,
                   fmt::format("{}: no welcome of Grbl's within {:.3g} s", name(), limit.count())};
    }
  }
}

Result<void> Line::Hear(Seconds limit) {
  for (int heard = 0; heard < kMostHeard; ++heard) {
    const Result<Message> message = Next(heard == 0 ? limit : Seconds(0));
    if (message || message.error().code == ErrorCode::kProtocol) continue;
    if (message.error().code == ErrorCode::kTimeout) return {};
    return message.error();
  }
  return Error{ErrorCode::kProtocol, fmt::format("{}: talks without end", name())};
}

Result<Report> Line::AskStatus() {
  for (int i = 0; i <= kReportsBetweenOffsets; ++i) {
    const Result<Report> report = AskedTwice([this] { return AskOnce(); });
    if (!report || !report->work) return report;
  }
  return Error{ErrorCode::kProtocol,
               fmt::format("{}: reports work positions, and never their offset", name())};
}

Result<Report> Line::AskOnce() {
  if (const Result<void> heard = Hear(Seconds(0)); !heard) return heard.error();
  if (condition_.homing_ || condition_.blocked_) return last_;
  if (const Result<void> sent = Send(kAskStatus); !sent) return sent.error();
  const Deadline deadline(reply_limit_);
  do {
    Result<Message> message = Next(deadline.Left());
    if (!message) {
      owes_ = true;  // it may still come
      return Error{message.error().code, message.error().message + ", asked ?"};
    }
    if (message->kind == Kind::kReport) return std::move(message->report);
    if (condition_.blocked_) return last_;
  } while (deadline.Left() > Seconds(0));
  return Error{ErrorCode::kTimeout,
               fmt::format("{}: no report within {:.3g} s", name(), reply_limit_.count())};
}

Result<std::vector<Message>> Line::Tell(const std::string& line) {
  if (const Result<void> heard = Hear(Seconds(0)); !heard) return heard.error();
  if (owes_) {
    if (const Result<void> caught_up = CatchUp(); !caught_up) return caught_up.error();
  }
  const auto failed = [&](ErrorCode code, const std::string& why) {
    return Error{code, fmt::format("{}, told {}", why, line)};
  };
  if (const auto sent = link_->Write(line + '\n', reply_limit_); !sent) return sent.error();
  owes_ = true;
  std::vector<Message> said;
  const Deadline deadline(reply_limit_);
  do {
    Result<Message> message = Next(deadline.Left());
    if (!message) return failed(message.error().code, message.error().message);
    switch (message->kind) {
      case Kind::kOk:
        owes_ = false;
        return said;
      case Kind::kError:
        owes_ = false;
        return Error{ErrorCode::kRefused,
                     fmt::format("{}: refused {}: {}", name(), line, TextOfError(message->code))};
      case Kind::kAlarm:
        return failed(ErrorCode::kProtocol, fmt::format("{}: {}", name(), condition_.fault_));
      case Kind::kWelcome:
        return failed(ErrorCode::kProtocol, name() + ": was reset");
      default:
        if (said.size() < kMostSaid) said.push_back(std::move(*message));
    }
  } while (deadline.Left() > Seconds(0));
  return failed(ErrorCode::kTimeout,
                fmt::format("{}: no \"ok\" within {:.3g} s", name(), reply_limit_.count()));
}

// Answers have no numbers. The parser's state is answered like nothing else, and after all lines
// before it: an "ok" that comes earlier belongs to one of those.
Result<void> Line::CatchUp() {
  if (const auto sent = link_->Write("$G\n", reply_limit_); !sent) return sent.error();
  const Deadline deadline(reply_limit_);
  bool answered = false;
  do {
    const Result<Message> message = Next(deadline.Left());
    if (!message) return Error{message.error().code, message.error().message + ", told $G"};
    if (message->kind == Kind::kNote && message->text.substr(0, 3) == "GC:") answered = true;
    if (message->kind == Kind::kOk && answered) owes_ = false;
    if (!owes_) return {};
  } while (deadline.Left() > Seconds(0));
  return Error{ErrorCode::kTimeout,
               fmt::format("{}: no answer to $G within {:.3g} s", name(), reply_limit_.count())};
}

Result<void> Line::Send(char byte) {
  return link_->Write(std::string_view(&byte, 1), reply_limit_);
}

Result<void> Line::Reset() {
  if (const Result<void> sent = Send(kReset); !sent) return sent;
  condition_.homed_ = condition_.homing_ = condition_.blocked_ = false;
  const Result<void> back = AwaitWelcome(reply_limit_ + kResetTakes);
  if (back) condition_.fault_.clear();
  return back;
}

Result<void> Line::StartHoming() {
  if (owes_) {
    if (const Result<void> caught_up = CatchUp(); !caught_up) return caught_up;
  }
  if (const auto sent = link_->Write("$H\n", reply_limit_); !sent) return sent;
  condition_.homed_ = false;
  condition_.homing_ = true;
  condition_.fault_.clear();
  return {};
}

}  // namespace gonio::grbl
