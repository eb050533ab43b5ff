// SPDX-License-Identifier: Apache-2.0
// What our layers cost over the bare libraries, with the same doubles and the same bytes:
//
//   umockdev-wrapper build/release/bin/gonio_wire_benchmarks
//
// BM_State asks a driver how its axis is; BM_BareState sends the bytes that it sent and reads as
// many as it was answered, by libserialport and poll alone. BM_UsbtmcQuery and BM_BareUsbQuery are
// the same for one SCPI query by libusb (only under umockdev-wrapper).
#include <benchmark/benchmark.h>
#include <libserialport.h>
#include <libusb.h>
#include <poll.h>
#include <sys/resource.h>

#include <sstream>
#include <vector>

#include "drivers/axis_opener.h"
#include "drivers/usbtmc.h"
#include "sim/usb_bench.h"
#include "sim/usbtmc_emulator.h"
#include "sim/wire_bench.h"

namespace gonio {
namespace {

AxisLimits Limits() {
  return {.min_position = -2.5,  // what a Grbl can reach is negative
          .max_position = -0.1,
          .max_speed = 0.25,
          .acceleration = 1,
          .position_tolerance = 1e-3};
}

struct Named {
  const char* name;
  AxisProtocol protocol;
  const char* stage;
  int address;
};
constexpr Named kProtocols[] = {
    {"zaber", AxisProtocol::kZaber, "", 1},    {"smc100", AxisProtocol::kSmc100, "", 1},
    {"apt", AxisProtocol::kApt, "PRM1-Z8", 0}, {"esp301", AxisProtocol::kEsp301, "", 1},
    {"gcs2", AxisProtocol::kGcs2, "", 0},      {"grbl", AxisProtocol::kGrbl, "", 1}};

// One double at the end of a line.
struct Line {
  Line(const Named& named, std::shared_ptr<Clock> clock) : bench(std::move(clock)) {
    device.protocol = named.protocol;
    device.stage = named.stage;
    device.address = named.address;
    device.port.port = "line";
    bench.Add(device, Limits());
    bench.Serve();
    device.port.port = bench.PathOf(0);
  }
  std::unique_ptr<Axis> Open(Clock* clock, std::shared_ptr<LinkLog> log) const {
    AxisOpener opener(clock, std::move(log));
    ControllerAxisSettings settings;
    settings.name = "arm";
    settings.limits = Limits();
    auto axis = opener.Open(device, settings);
    GONIO_CHECK(axis.ok(), axis.ok() ? "" : axis.error().message);
    return std::move(axis).value();
  }

  WireBench bench;
  AxisDevice device;
};

void BM_State(benchmark::State& state) {
  const Named& named = kProtocols[state.range(0)];
  const auto clock = std::make_shared<ManualClock>();
  const Line line(named, clock);
  const auto axis = line.Open(clock.get(), std::make_shared<LinkLog>(clock.get()));
  GONIO_CHECK(axis->Home({}).ok(), "homed");
  for (auto _ : state) benchmark::DoNotOptimize(axis->State().ok());
  state.SetLabel(named.name);
}
BENCHMARK(BM_State)->DenseRange(0, 5)->UseRealTime();

struct Step {
  std::string sent;
  std::size_t answered = 0;  // bytes
};

// The bytes of a log line, which has those that are no plain text as \x1b.
std::string Unescaped(std::string_view text) {
  std::string bytes;
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text.substr(i, 2) == "\\x") {
      bytes += static_cast<char>(std::stoi(std::string(text.substr(i + 2, 2)), nullptr, 16));
      i += 3;
    } else {
      bytes += text[i];
    }
  }
  return bytes;
}

long Sent(const LinkLog& log) { return log.Counts().begin()->second.sent; }

// What one State() sends and is answered: the last of what is in the log.
std::vector<Step> StepsOf(Axis& axis, const LinkLog& log) {
  const long before = Sent(log);
  GONIO_CHECK(axis.State().ok(), "answered");
  std::istringstream lines(log.Last(LinkLog::kKept));
  std::vector<Step> steps;
  for (std::string line; std::getline(lines, line);) {
    const std::string bytes =
        Unescaped(line.substr(line.find('"') + 1, line.rfind('"') - line.find('"') - 1));
    if (line.find(" > ") != std::string::npos) {
      steps.push_back({bytes, 0});
    } else if (!steps.empty()) {
      steps.back().answered += bytes.size();
    }
  }
  steps.erase(steps.begin(), steps.end() - (Sent(log) - before));
  return steps;
}

// The bare library, as its own examples use it.
class BarePort {
 public:
  explicit BarePort(const std::string& path) {
    GONIO_CHECK(sp_get_port_by_name(path.c_str(), &port_) == SP_OK, "found");
    GONIO_CHECK(sp_open(port_, SP_MODE_READ_WRITE) == SP_OK, "opened");
    sp_get_port_handle(port_, &descriptor_);
  }
  ~BarePort() {
    sp_close(port_);
    sp_free_port(port_);
  }
  void Exchange(const Step& step) {
    sp_nonblocking_write(port_, step.sent.data(), step.sent.size());
    char buffer[256];
    for (std::size_t count = 0; count < step.answered;) {
      pollfd ready{.fd = descriptor_, .events = POLLIN, .revents = 0};
      poll(&ready, 1, 1000);
      const sp_return got = sp_nonblocking_read(port_, buffer, sizeof buffer);
      GONIO_CHECK(got >= 0, "read");
      count += static_cast<std::size_t>(got);
    }
  }

 private:
  sp_port* port_ = nullptr;
  int descriptor_ = -1;
};

void BM_BareState(benchmark::State& state) {
  const Named& named = kProtocols[state.range(0)];
  const auto clock = std::make_shared<ManualClock>();
  const Line line(named, clock);
  std::vector<Step> steps;
  {
    const auto log = std::make_shared<LinkLog>(clock.get());
    const auto axis = line.Open(clock.get(), log);
    GONIO_CHECK(axis->Home({}).ok(), "homed");
    steps = StepsOf(*axis, *log);
  }
  BarePort port(line.device.port.port);
  for (auto _ : state) {
    for (const Step& step : steps) port.Exchange(step);
  }
  state.SetLabel(named.name);
}
BENCHMARK(BM_BareState)->DenseRange(0, 5)->UseRealTime();

double CpuSeconds() {
  rusage usage{};
  getrusage(RUSAGE_THREAD, &usage);
  const auto seconds = [](const timeval& time) { return time.tv_sec + 1e-6 * time.tv_usec; };
  return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

// A move of ten seconds; "cpu_share" is what waiting for it took of one core.
void BM_WaitForAMove(benchmark::State& state) {
  const Named& named = kProtocols[state.range(0)];
  const auto clock = std::make_shared<SystemClock>();
  const Line line(named, clock);
  const auto axis = line.Open(clock.get(), std::make_shared<LinkLog>(clock.get()));
  GONIO_CHECK(axis->Home({}).ok(), "homed");
  for (auto _ : state) {
    const double from = axis->State()->position;
    GONIO_CHECK(axis->StartMove(from < -1.3 ? from + 2.2 : from - 2.2).ok(), "started");
    const double cpu = CpuSeconds();
    const Seconds begin = clock->Now();
    GONIO_CHECK(axis->WaitUntilStill(Seconds(60), {}).ok(), "arrived");
    const Seconds took = clock->Now() - begin;
    state.counters["move_s"] = took.count();
    state.counters["cpu_share"] = (CpuSeconds() - cpu) / took.count();
  }
  state.SetLabel(named.name);
}
BENCHMARK(BM_WaitForAMove)->DenseRange(0, 5)->Iterations(1)->UseRealTime();

constexpr const char* kQuestion = "*IDN?\n";
constexpr const char* kAnswer = "Maker,Model,Serial,1.0";

// Plugged in, if this program can see it.
struct Instrument {
  UsbtmcEmulator device{
      {.vendor = 0x1313, .product = 0x8078, .maker = "", .description = "", .serial = "P1"},
      [](std::string_view) { return std::string(kAnswer); }};
  UsbBench bench;
  Instrument() { bench.Plug(&device); }
};

void BM_UsbtmcQuery(benchmark::State& state) {
  if (!UsbBench::SeenFromHere()) return state.SkipWithError("needs umockdev-wrapper");
  Instrument instrument;
  auto link = UsbtmcDevice::Open({.vendor = 0x1313, .products = {0x8078}, .serial = ""});
  GONIO_CHECK(link.ok(), "opened");
  for (auto _ : state) {
    GONIO_CHECK((*link)->Write(kQuestion, Seconds(1)).ok(), "sent");
    GONIO_CHECK((*link)->Read(Seconds(1)).ok(), "answered");
  }
}
BENCHMARK(BM_UsbtmcQuery)->UseRealTime();

void Transfer(libusb_device_handle* handle, unsigned char endpoint, std::string* bytes) {
  int count = 0;
  GONIO_CHECK(
      libusb_bulk_transfer(handle, endpoint, reinterpret_cast<unsigned char*>(bytes->data()),
                           static_cast<int>(bytes->size()), &count, 1000) == 0,
      "transferred");
}

// Header and padding of the class, written down by hand.
void BM_BareUsbQuery(benchmark::State& state) {
  if (!UsbBench::SeenFromHere()) return state.SkipWithError("needs umockdev-wrapper");
  Instrument instrument;
  libusb_context* context = nullptr;
  GONIO_CHECK(libusb_init(&context) == 0, "libusb");
  libusb_device_handle* handle = libusb_open_device_with_vid_pid(context, 0x1313, 0x8078);
  GONIO_CHECK(handle != nullptr, "opened");
  libusb_set_auto_detach_kernel_driver(handle, 1);
  libusb_config_descriptor* config = nullptr;
  libusb_get_active_config_descriptor(libusb_get_device(handle), &config);
  unsigned char in = 0;
  unsigned char out = 0;
  int number = 0;
  for (int i = 0; i < config->bNumInterfaces; ++i) {
    const libusb_interface_descriptor& interface = config->interface[i].altsetting[0];
    if (interface.bInterfaceClass != 0xfe || interface.bInterfaceSubClass != 3) continue;
    number = interface.bInterfaceNumber;
    for (int e = 0; e < interface.bNumEndpoints; ++e) {
      const auto& endpoint = interface.endpoint[e];
      if ((endpoint.bmAttributes & 3) != 2) continue;
      ((endpoint.bEndpointAddress & 0x80) != 0 ? in : out) = endpoint.bEndpointAddress;
    }
  }
  libusb_free_config_descriptor(config);
  GONIO_CHECK(libusb_claim_interface(handle, number) == 0, "claimed");
  std::uint8_t tag = 0;
  const auto header = [&](char id, std::size_t size, char attributes) {
    tag = static_cast<std::uint8_t>(tag % 255 + 1);
    std::string bytes(12, '\0');
    bytes[0] = id;
    bytes[1] = static_cast<char>(tag);
    bytes[2] = static_cast<char>(~tag);
    bytes[4] = static_cast<char>(size & 0xff);
    bytes[5] = static_cast<char>(size >> 8);
    bytes[8] = attributes;
    return bytes;
  };
  for (auto _ : state) {
    std::string message = header(1, 6, 1) + kQuestion + std::string(2, '\0');
    Transfer(handle, out, &message);
    std::string request = header(2, 1024, 0);
    Transfer(handle, out, &request);
    std::string answer(1024, '\0');
    Transfer(handle, in, &answer);
  }
  libusb_release_interface(handle, number);
  libusb_close(handle);
  libusb_exit(context);
}
BENCHMARK(BM_BareUsbQuery)->UseRealTime();

}  // namespace
}  // namespace gonio
