// SPDX-License-Identifier: Apache-2.0
// That the libraries find what is plugged into a bench, from here and from another program.
#include "sim/usb_bench.h"

#include <gmock/gmock.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>

#include "drivers/serial_port.h"
#include "sim/pty_server.h"
#include "tests/usb/usb_instrument.h"

namespace gonio {
namespace {

SerialAdapter AdapterOf(const std::string& node, const std::string& serial, const PtyServer& line) {
  SerialAdapter adapter;
  adapter.plate.serial = serial;
  adapter.node = node;
  adapter.line = line.path();
  return adapter;
}

std::string Shout(std::string_view bytes) {
  std::string answer(bytes);
  std::transform(answer.begin(), answer.end(), answer.begin(),
                 [](char c) { return static_cast<char>(std::toupper(c)); });
  return answer;
}

// As a program would ask that knows only the adapter's serial number.
std::string AskPort(const std::string& port, const std::string& question) {
  SerialSettings settings;
  settings.port = port;
  const auto opened = SerialPort::Open(settings);
  if (!opened) return opened.error().message;
  if (const auto sent = (*opened)->Write(question, kLongLimit); !sent) return sent.error().message;
  std::string answer;
  while (answer.size() < question.size()) {
    const auto more = (*opened)->Read(question.size(), kLongLimit);
    if (!more) return more.error().message;
    answer += *more;
  }
  return answer;
}

TEST(UsbBench, HasNothingAtFirst) {
  UsbBench bench;
  EXPECT_TRUE(UsbBench::SeenFromHere());
  const auto instruments = ListUsbtmcDevices();
  ASSERT_TRUE(instruments.ok());
  EXPECT_TRUE(instruments->empty());
}

TEST(UsbBench, TakesSerialAdaptersAndInstruments) {
  PtyServer first(Shout);
  PtyServer second(Shout);
  UsbtmcEmulator instrument(PlateOf(0x8078, "P1"), Shout);
  UsbBench bench;
  bench.Plug(AdapterOf("ttyUSB0", "A1", first));
  bench.Plug(&instrument);
  bench.Plug(AdapterOf("ttyUSB1", "A2", second));
  const auto ports = ListSerialPorts();
  ASSERT_TRUE(ports.ok()) << ports.error().message;
  ASSERT_EQ(ports->size(), 2u);
  EXPECT_EQ((*ports)[1].path, "/dev/ttyUSB1");
  EXPECT_EQ((*ports)[1].usb_id, "0403:6001");
  EXPECT_EQ((*ports)[1].usb_serial, "A2");
  EXPECT_EQ(AskPort("/dev/ttyUSB0", "stage"), "STAGE");
  EXPECT_EQ(AskPort("usb:A2", "lamp"), "LAMP");
  EXPECT_EQ(ListUsbtmcDevices()->size(), 1u);
  bench.Unplug(AdapterOf("ttyUSB0", "A1", first));
  EXPECT_EQ(ListSerialPorts()->size(), 1u);
  EXPECT_EQ(AskPort("usb:A1", "x"), "usb:A1: no serial port with this USB serial number");
  bench.Plug(AdapterOf("ttyUSB0", "A1", first));
  EXPECT_EQ(AskPort("usb:A1", "again"), "AGAIN");
  EXPECT_THROW(bench.Plug(AdapterOf("ttyUSB0", "A3", second)), ConfigError);
}

// What the other program does; run by the test below only.
TEST(UsbBenchProgram, DISABLED_AsksBoth) {
  EXPECT_EQ(AskPort("usb:A1", "stage"), "STAGE");
  const auto device = OpenedDevice(PlateOf(0x8078, "P1"));
  ASSERT_NE(device, nullptr);
  for (int i = 0; i < 20; ++i) {
    ASSERT_TRUE(device->Write("lamp\n", kLongLimit).ok());
    ASSERT_EQ(*device->Read(kLongLimit), "LAMP\n");
  }
}

TEST(UsbBench, IsSeenByTheProgramsThatAreStarted) {
  PtyServer line(Shout);
  UsbtmcEmulator instrument(PlateOf(0x8078, "P1"), Shout);
  UsbBench bench;
  bench.Plug(AdapterOf("ttyUSB0", "A1", line));
  bench.Plug(&instrument);
  const pid_t program = fork();
  ASSERT_GE(program, 0);
  if (program == 0) {
    execl("/proc/self/exe", "usb_test", "--gtest_also_run_disabled_tests", "--gtest_brief=1",
          "--gtest_filter=UsbBenchProgram.*", nullptr);
    _exit(127);
  }
  int status = -1;
  ASSERT_EQ(waitpid(program, &status, 0), program);
  EXPECT_TRUE(WIFEXITED(status));
  EXPECT_EQ(WEXITSTATUS(status), 0);
  // What the program had open is free again.
  EXPECT_NE(OpenedDevice(PlateOf(0x8078, "P1")), nullptr);
}

}  // namespace
}  // namespace gonio
