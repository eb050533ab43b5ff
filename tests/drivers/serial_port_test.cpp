// SPDX-License-Identifier: Apache-2.0
// The real libserialport, on pseudo-terminals (sim/pty_modem_lines.cpp lets it open them).
#include "drivers/serial_port.h"

#include <gtest/gtest.h>

#include <ctime>
#include <future>
#include <optional>
#include <thread>

#include "sim/pty.h"
#include "tests/core/temp_dir.h"

namespace gonio {
namespace {

using namespace std::chrono_literals;

constexpr Seconds kLong = 5s;  // never waited for unless a test fails
constexpr Seconds kShort = 30ms;

std::unique_ptr<SerialPort> Opened(const Pty& pty, SerialSettings settings = {}) {
  settings.port = pty.path();
  Result<std::unique_ptr<SerialPort>> port = SerialPort::Open(settings);
  EXPECT_TRUE(port.ok()) << port.error().message;
  return std::move(port).value();
}

// As many bytes as the far end is expected to have sent.
std::string ReadAll(SerialPort& port, std::size_t count) {
  std::string all;
  while (all.size() < count) {
    const Result<std::string> some = port.Read(count - all.size(), kLong);
    if (!some) return all + " then " + some.error().message;
    all += *some;
  }
  return all;
}

double ProcessorSeconds() {
  timespec time = {};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

// As in /dev/serial/by-id. Example failure is "no such port" for a name the system itself gives.
TEST(SerialPort, OpensWhatALinkLeadsTo) {
  Pty pty;
  const TempDir dir;
  std::filesystem::create_symlink(pty.path(), dir / "usb-Maker_Stage_A1");
  SerialSettings settings;
  settings.port = dir / "usb-Maker_Stage_A1";
  const auto port = SerialPort::Open(settings);
  ASSERT_TRUE(port.ok()) << port.error().message;
  pty.Send("abc");
  EXPECT_EQ(ReadAll(**port, 3), "abc");
}

TEST(SerialPort, CarriesEveryByteBothWays) {
  Pty pty;
  const auto port = Opened(pty);
  std::string all;
  for (int byte = 0; byte < 256; ++byte) all += static_cast<char>(byte);
  pty.Send(all);
  EXPECT_EQ(ReadAll(*port, all.size()), all);
  ASSERT_TRUE(port->Write(all, kLong).ok());
  std::string arrived;
  while (arrived.size() < all.size()) {
    const std::string some = pty.Receive(kLong);
    ASSERT_FALSE(some.empty());
    arrived += some;
  }
  EXPECT_EQ(arrived, all);
}

TEST(SerialPort, ReturnsWhatIsThereWithoutWaitingForMore) {
  Pty pty;
  const auto port = Opened(pty);
  pty.Send("abc");
  EXPECT_EQ(*port->Read(2, kLong), "ab");
  EXPECT_EQ(*port->Read(100, kLong), "c");
}

TEST(SerialPort, SaysThatNothingCameInTime) {
  Pty pty;
  const auto port = Opened(pty);
  const double before = ProcessorSeconds();
  const Result<std::string> nothing = port->Read(1, kShort);
  EXPECT_LT(ProcessorSeconds() - before, 0.5 * kShort.count());
  ASSERT_FALSE(nothing.ok());
  EXPECT_EQ(nothing.error().code, ErrorCode::kTimeout);
  EXPECT_EQ(nothing.error().message, pty.path() + ": no answer within 0.03 s");
  pty.Send("late");
  EXPECT_EQ(ReadAll(*port, 4), "late");  // still open
}

TEST(SerialPort, SaysThatAFullLineTakesNoMore) {
  Pty pty;
  const auto port = Opened(pty);
  const Result<void> stuck = port->Write(std::string(1 << 20, 'x'), kShort);
  ASSERT_FALSE(stuck.ok());
  EXPECT_EQ(stuck.error().code, ErrorCode::kTimeout);
  EXPECT_EQ(stuck.error().message, pty.path() + ": not all bytes were taken within 0.03 s");
}

TEST(SerialPort, NoticesAtOnceThatTheCableIsOut) {
  std::optional<Pty> pty(std::in_place);
  const auto port = Opened(*pty);
  auto reading = std::async(std::launch::async, [&] { return port->Read(1, kLong); });
  pty.reset();
  const Result<std::string> gone = reading.get();
  ASSERT_FALSE(gone.ok());
  EXPECT_EQ(gone.error().code, ErrorCode::kDisconnected);
  EXPECT_EQ(gone.error().message, port->name() + ": disconnected");
  EXPECT_EQ(port->Read(1, kLong).error().code, ErrorCode::kDisconnected);
  EXPECT_EQ(port->Write("x", kLong).error().code, ErrorCode::kDisconnected);
  EXPECT_EQ(port->DiscardInput().error().code, ErrorCode::kDisconnected);
}

TEST(SerialPort, ForgetsWhatCameInBefore) {
  Pty pty;
  pty.Send("before it was opened");
  const auto port = Opened(pty);
  EXPECT_EQ(port->Read(1, kShort).error().code, ErrorCode::kTimeout);
  pty.Send("stale");
  ASSERT_EQ(*port->Read(1, kLong), "s");  // so all of it has come in
  ASSERT_TRUE(port->DiscardInput().ok());
  pty.Send("new");
  EXPECT_EQ(ReadAll(*port, 3), "new");
}

TEST(SerialPort, BelongsToOneOwner) {
  Pty pty;
  SerialSettings same;
  same.port = pty.path();
  {
    const auto port = Opened(pty);
    const auto second = SerialPort::Open(same);
    ASSERT_FALSE(second.ok());
    EXPECT_EQ(second.error().code, ErrorCode::kRefused);
    EXPECT_EQ(second.error().message, pty.path() + ": in use by another program");
  }
  EXPECT_TRUE(SerialPort::Open(same).ok());
}

TEST(SerialPort, TakesTheSettingsOfAllOurDevices) {
  for (const int baud : {9600, 19200, 38400, 57600, 115200, 921600}) {
    for (const auto flow : {SerialSettings::Flow::kNone, SerialSettings::Flow::kRtsCts,
                            SerialSettings::Flow::kXonXoff}) {
      Pty pty;
      SerialSettings settings;
      settings.baud = baud;
      settings.flow = flow;
      settings.dtr = settings.rts = false;
      EXPECT_NE(Opened(pty, settings), nullptr);
    }
  }
}

TEST(SerialPort, RefusesSettingsThatItCannotHave) {
  Pty pty;
  const auto message_of = [&](SerialSettings settings) {
    settings.port = pty.path();
    const auto opened = SerialPort::Open(settings);
    return opened.ok() ? "opened" : opened.error().message;
  };
  SerialSettings settings;
  settings.baud = 0;
  EXPECT_EQ(message_of(settings), pty.path() + ": cannot have 0 baud: invalid argument");
  settings = {};
  settings.stop_bits = 3;
  EXPECT_EQ(message_of(settings), pty.path() + ": cannot have 3 stop bits: invalid argument");
  EXPECT_EQ(message_of({}), "opened");  // nothing stays locked
}

TEST(SerialPort, NamesThePortThatIsNotThere) {
  const auto message_of = [](const std::string& port) {
    SerialSettings settings;
    settings.port = port;
    const auto opened = SerialPort::Open(settings);
    return opened.ok() ? "opened" : opened.error().message;
  };
  EXPECT_EQ(message_of("/dev/ttyNOWHERE"),
            "/dev/ttyNOWHERE: no such serial port; gonio devices lists those there are");
  EXPECT_EQ(message_of("usb:NOBODY"), "usb:NOBODY: no serial port with this USB serial number");
  EXPECT_EQ(message_of("usb:"), "usb:: no serial port with this USB serial number");
}

}  // namespace
}  // namespace gonio
