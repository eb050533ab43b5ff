// SPDX-License-Identifier: Apache-2.0
// PI's General Command Set, version 2, as text.

#pragma once

#include <string>
#include <string_view>

#include "core/error.h"

namespace gonio::gcs2 {

// "MOV 1 10.5\n"; of controller 2 on a daisy chain "2 MOV 1 10.5\n"; address 0: there is no chain.
// After a command of one byte there is no end of line.
std::string Encode(int address, std::string_view command);

// Commands of one byte, obeyed as soon as it is there.
inline constexpr char kMotionStatus[] = "\x05";
inline constexpr char kIsReady[] = "\x07";
inline constexpr char kStopAll[] = "\x18";
// A command as a message shows it: "#5" for kMotionStatus.
std::string Shown(std::string_view command);

// Every line of a reply but the last ends with a blank.
bool IsLastLine(std::string_view line);
// The first line of a reply without what a chain puts before: "1=3" of "0 2 1=3". kProtocol: it
// comes from another controller.
Result<std::string> FromController(int address, std::string_view line);

// What no other reply looks like, that to *IDN?, with or without what a chain puts before.
bool IsIdentity(std::string_view line);

// The part of a line after "NAME=", blanks around it left out. All errors are kProtocol.
Result<std::string> ValueOf(std::string_view line, std::string_view name);
Result<double> NumberOf(std::string_view line, std::string_view name);  // finite
Result<bool> FlagOf(std::string_view line, std::string_view name);      // "0", "1"

// The name in a line of the reply to SAI?, "1 ".
std::string NameIn(std::string_view line);
// The reply to kMotionStatus, "1A": bit 0 is set while the first axis moves, ...
Result<unsigned> MovingIn(std::string_view line);
// The reply to kIsReady, a byte that is no letter.
Result<bool> ReadyIn(std::string_view line);
// The reply to CSV?, "2.0".
Result<double> SyntaxIn(std::string_view line);
// The reply to SPA? for its unit, "1 0x07000601=DEG".
Result<std::string> UnitIn(std::string_view line);
bool IsDegrees(std::string_view unit);

// The reply to ERR?, "-1024".
inline constexpr int kUnknownCommand = 2;
Result<int> ErrorIn(std::string_view line);
// Whether it says that something was not as it should be: not 0, nor that somebody stopped it.
bool IsError(int error);
// In words: "position out of limits".
std::string TextOf(int error);
// Whether it happened by itself, rather than refuse a command. One that is not known is taken for a
// fault.
bool IsFault(int error);

}  // namespace gonio::gcs2
