// SPDX-License-Identifier: Apache-2.0
// What Grbl 1.1 says and is told, as text (https://github.com/gnea/grbl, doc/markdown).

#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/error.h"

namespace gonio::grbl {

// Single bytes that are picked out of the stream at once, whatever Grbl is doing: without an end of
// line, and without an "ok".
inline constexpr char kAskStatus = '?';
inline constexpr char kFeedHold = '!';
inline constexpr char kCancelJog =
    '\x85';  // brakes and forgets all jogs; nothing if there are none
inline constexpr char kReset = '\x18';

inline constexpr int kMostAxes = 4;  // in the order of reports
inline constexpr std::string_view kAxisLetters = "XYZA";

enum class State { kIdle, kRun, kHold, kJog, kAlarm, kDoor, kCheck, kHome, kSleep };

// What an answer to kAskStatus holds, as far as it is of use here.
struct Report {
  State state = State::kIdle;
  int detail = 0;                // of kHold and kDoor: 0 at rest and may be resumed
  std::vector<double> position;  // per axis, in units of the machine
  bool work = false;             // position counts from `offset`, not from the machine's zero
  std::vector<double> offset;    // empty in most reports
};

enum class Kind {
  kOk,       // the line before was understood
  kError,    // it was not: code
  kAlarm,    // code; nothing moves until it is homed
  kReport,   // report
  kWelcome,  // it was reset; text is its version, "1.1h"
  kSetting,  // $code=text
  kNote,     // anything else that belongs to Grbl: "[MSG:...]" without its brackets, start-up lines
};

struct Message {
  Kind kind = Kind::kNote;
  int code = 0;
  std::string text;
  Report report;
};

// A line without its end. kProtocol: not one of Grbl's.
Result<Message> Decode(std::string_view line);

// One straight move of some axes.
struct Leg {
  std::array<std::optional<double>, kMostAxes> target;  // in the machine's coordinates
  double feed = 0;                                      // units per minute, along the way
};

// "$J=G21G53X-12.5000F600.000", a line without its end: a jog, in millimetres as far as Grbl knows,
// in the machine's coordinates whatever offsets are in force. Precondition: a target, feed > 0,
// both below 1e6.
std::string Encode(const Leg& leg);

// In words, as part of a sentence: "error 15, beyond the travel of the axis".
std::string TextOfError(int code);
std::string TextOfAlarm(int code);
std::string TextOf(State state);

}  // namespace gonio::grbl
