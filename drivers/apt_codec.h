// SPDX-License-Identifier: Apache-2.0
// Thorlabs' APT protocol, as bytes (APT Communications Protocol, issue 16).

#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "core/error.h"

namespace gonio::apt {

// Who speaks and is spoken to.
inline constexpr int kHost = 0x01;
inline constexpr int kRack = 0x11;      // the frame that cards are plugged into
inline constexpr int kFirstBay = 0x21;  // its cards: kFirstBay .. kLastBay
inline constexpr int kLastBay = 0x2a;
inline constexpr int kUsbUnit = 0x50;  // a controller without cards

// Kinds of messages, called as in the manual less "MGMSG" and "MOT".
enum Id : std::uint16_t {
  kHwReqInfo = 0x0005,
  kHwGetInfo = 0x0006,
  kHwResponse = 0x0080,
  kHwRichResponse = 0x0081,
  kSetChanEnableState = 0x0210,
  kSetVelParams = 0x0413,
  kReqVelParams = 0x0414,
  kGetVelParams = 0x0415,
  kReqStatusBits = 0x0429,
  kGetStatusBits = 0x042a,
  kSetGenMoveParams = 0x043a,
  kReqGenMoveParams = 0x043b,
  kGetGenMoveParams = 0x043c,
  kReqHomeParams = 0x0441,
  kGetHomeParams = 0x0442,
  kMoveHome = 0x0443,
  kMoveHomed = 0x0444,
  kMoveAbsolute = 0x0453,
  kMoveCompleted = 0x0464,
  kMoveStop = 0x0465,
  kMoveStopped = 0x0466,
  kReqStatusUpdate = 0x0480,
  kGetStatusUpdate = 0x0481,
  kReqDcStatusUpdate = 0x0490,
  kGetDcStatusUpdate = 0x0491,
  kAckDcStatusUpdate = 0x0492,
};
// "REQ_VELPARAMS"; "message 0x0691" for those not listed above.
std::string NameOf(std::uint16_t id);

// A motor, and whom to talk to about it.
struct Address {
  int module = kUsbUnit;
  int channel = 1;  // 1 .. 255; of a card always 1
};

struct Message {
  std::uint16_t id = 0;
  int dest = kHost;  // 7 bits
  int source = kHost;
  std::uint8_t p1 = 0;  // of messages without data
  std::uint8_t p2 = 0;
  std::optional<std::string> data;
};
inline constexpr std::size_t kHeaderBytes = 6;
inline constexpr std::size_t kMostData = 255;  // that a message carries

// Precondition: at most kMostData bytes of data.
std::string Encode(const Message& message);

// Takes the first message for the host off the front of `bytes`. Nothing: it is not complete.
// kProtocol: what is there is no message from a controller; `bytes` stays. There is no checksum,
// nor anything by which to find the next beginning.
Result<std::optional<Message>> TakeMessage(std::string* bytes);

// Which of its module's motors a message is about, if it is about one.
std::optional<int> ChannelOf(const Message& message);

// Messages of the host.
Message AboutMotor(Id id, const Address& address, int p2 = 0);
Message MoveTo(const Address& address, std::int32_t position);
struct Velocity {
  int channel = 1;
  std::int32_t least = 0;  // speeds and acceleration in units of the controller
  std::int32_t acceleration = 0;
  std::int32_t most = 0;
};
Message SetVelocity(int module, const Velocity& velocity);
struct Backlash {
  int channel = 1;
  std::int32_t distance = 0;  // counts
};
Message SetBacklash(int module, const Backlash& backlash);

// Messages of the controller. kProtocol: it is another one, or not as long as it should be.
Result<Velocity> DecodeVelocity(const Message& message);
Result<Backlash> DecodeBacklash(const Message& message);

struct Homing {
  int channel = 1;
  int direction = 0;
  int limit_switch = 0;
  std::int32_t velocity = 0;
  std::int32_t offset = 0;  // counts
};
Result<Homing> DecodeHoming(const Message& message);

struct Info {
  std::int32_t serial = 0;  // cards need not know theirs, and say -1
  std::string model;        // "KDC101"
  std::string firmware;     // "2.0.3"
};
Result<Info> DecodeInfo(const Message& message);

struct Status {
  int channel = 1;
  std::int32_t position = 0;  // counts
  std::uint32_t bits = 0;
};
// GET_STATUSUPDATE and GET_DCSTATUSUPDATE: they differ in what lies between.
Result<Status> DecodeStatus(const Message& message);

// Bits of a status. What is called forward and what reverse depends on the stage.
inline constexpr std::uint32_t kLimitSwitches = 0x3;
inline constexpr std::uint32_t kSoftLimits = 0xc;
inline constexpr std::uint32_t kTurning = 0xaf0;  // moving, jogging, homing, initialising
inline constexpr std::uint32_t kHoming = 0x200;
inline constexpr std::uint32_t kHomed = 0x400;
inline constexpr std::uint32_t kInterlock = 0x10000;  // closed or open, by controller
inline constexpr std::uint32_t kEnabled = 0x80000000;
// Those that are faults whatever goes on, in words: "motion error, over-current"; empty: none. Not
// among them is the limiting of the current (0x1000000), which a stage may do while it speeds up:
// if it falls behind because of that, there is a motion error.
std::string FaultsIn(std::uint32_t bits);

// What went wrong, by HW_RESPONSE, which says nothing, or HW_RICHRESPONSE.
struct Report {
  std::uint16_t about = 0;  // the message that it is an answer to; 0: none, or it does not say
  std::string text;         // "error 112: \"axis not homed\""
};
// Nothing: it is another message.
std::optional<Report> ReportIn(const Message& message);

}  // namespace gonio::apt
