// SPDX-License-Identifier: Apache-2.0
#include "drivers/zaber_codec.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>

#include "core/check.h"
#include "drivers/wire_text.h"

namespace gonio::zaber {
namespace {

bool IsPlain(char c) {
  return static_cast<unsigned char>(c) < 0x80 &&
         std::string_view("/@#!:\\\r\n").find(c) == std::string_view::npos;
}

// The words of a line from its front; the last one is all that is left.
class Words {
 public:
  explicit Words(std::string_view rest) : rest_(rest) {}

  std::string_view Next() {
    const std::size_t end = std::min(rest_.find(' '), rest_.size());
    const std::string_view word = rest_.substr(0, end);
    rest_.remove_prefix(std::min(end + 1, rest_.size()));
    return word;
  }
  // The next word if it is a number of at most so much; else it stays.
  std::optional<int> NextNumber(int most) {
    const std::string_view word = Words(*this).Next();
    int number = 0;
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), number);
    if (word.empty() || error != std::errc() || end != word.data() + word.size() || number < 0 ||
        number > most) {
      return std::nullopt;
    }
    Next();
    return number;
  }
  std::string_view rest() const { return rest_; }

 private:
  std::string_view rest_;
};

Error Nonsense(std::string_view line, std::string_view what) {
  return {ErrorCode::kProtocol, fmt::format("{} {}", Quoted(line), what)};
}

// OK|RJ BUSY|IDLE and the flag, of which alerts lack the first. False: none of these.
bool DecodeStatus(Words* words, Message* message) {
  if (message->kind == Kind::kReply) {
    const std::string_view verdict = words->Next();
    if (verdict != "OK" && verdict != "RJ") return false;
    message->accepted = verdict == "OK";
  }
  const std::string_view state = words->Next();
  if (state != "BUSY" && state != "IDLE") return false;
  message->busy = state == "BUSY";
  const std::string_view flag = words->Next();
  if (flag.size() != 2) return false;
  if (flag != "--") message->warning = flag;
  return true;
}

}  // namespace

std::string Checksum(std::string_view bytes) {
  unsigned sum = 0;
  for (const char c : bytes) sum += static_cast<unsigned char>(c);
  return fmt::format("{:02X}", (256 - sum % 256) % 256);
}

std::string Encode(const Command& command) {
  GONIO_CHECK(std::all_of(command.data.begin(), command.data.end(), IsPlain),
              "data of a command is plain text");
  std::string body = fmt::format("{:02} {}", command.device, command.axis);
  if (command.id) body += fmt::format(" {}", *command.id);
  if (!command.data.empty()) body += ' ' + command.data;
  const std::string line = '/' + body + ':' + Checksum(body) + '\n';
  GONIO_CHECK(line.size() <= kMostBytes, "a command fits into a packet");
  return line;
}

Result<Message> Decode(std::string_view line) {
  Message message;
  const std::string_view kinds = "@#!";
  const std::size_t kind = line.empty() ? std::string_view::npos : kinds.find(line.front());
  if (kind == std::string_view::npos) return Nonsense(line, "is not a message of a Zaber device");
  message.kind = static_cast<Kind>(kind);
  std::string_view body = line.substr(1);
  if (const std::size_t colon = body.rfind(':'); colon != std::string_view::npos) {
    if (body.substr(colon + 1) != Checksum(body.substr(0, colon))) {
      return Nonsense(line, "has a wrong checksum");
    }
    body = body.substr(0, colon);
  }
  if (!body.empty() && body.back() == '\\') {
    message.continued = true;
    body.remove_suffix(1);
  }
  Words words(body);
  const std::optional<int> device = words.NextNumber(99);
  const std::optional<int> axis = words.NextNumber(9);
  if (!device || !axis) return Nonsense(line, "does not say from which device and axis it is");
  message.device = *device;
  message.axis = *axis;
  if (message.kind != Kind::kAlert) message.id = words.NextNumber(255);
  if (message.kind != Kind::kInfo && !DecodeStatus(&words, &message)) {
    return Nonsense(line, "has no status where one is due");
  }
  message.data = words.rest();
  return message;
}

}  // namespace gonio::zaber
