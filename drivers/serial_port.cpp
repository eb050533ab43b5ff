// SPDX-License-Identifier: Apache-2.0
#include "drivers/serial_port.h"

#include <fmt/format.h>
#include <libserialport.h>
#include <poll.h>
#include <sys/file.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <optional>
#include <system_error>
#include <utility>

#include "drivers/deadline.h"
#include "drivers/permission.h"

namespace gonio {
namespace {

constexpr std::string_view kByUsbSerial = "usb:";

std::string TextOf(const char* text) { return text == nullptr ? "" : text; }

SerialPortInfo InfoOf(const sp_port* port) {
  SerialPortInfo info{.path = TextOf(sp_get_port_name(port)),
                      .description = TextOf(sp_get_port_description(port)),
                      .usb_id = {},
                      .usb_serial = {}};
  int vendor = 0;
  int product = 0;
  if (sp_get_port_transport(port) == SP_TRANSPORT_USB &&
      sp_get_port_usb_vid_pid(port, &vendor, &product) == SP_OK) {
    info.usb_id = fmt::format("{:04x}:{:04x}", vendor, product);
    info.usb_serial = TextOf(sp_get_port_usb_serial(port));
  }
  return info;
}

Error Refused(std::string message) { return {ErrorCode::kRefused, std::move(message)}; }

// The path of a port that is given by path or by the serial number of its USB adapter.
Result<std::string> PathOf(const std::string& port) {
  if (port.compare(0, kByUsbSerial.size(), kByUsbSerial) != 0) return port;
  const std::string serial = port.substr(kByUsbSerial.size());
  const Result<std::vector<SerialPortInfo>> ports = ListSerialPorts();
  if (!ports) return ports.error();
  std::vector<std::string> found;
  for (const SerialPortInfo& info : *ports) {
    if (!serial.empty() && info.usb_serial == serial) found.push_back(info.path);
  }
  if (found.size() == 1) return found.front();
  if (found.empty()) {
    return Refused(fmt::format("{}: no serial port with this USB serial number", port));
  }
  return Refused(fmt::format("{}: {} ports have this USB serial number: {}", port, found.size(),
                             fmt::join(found, ", ")));
}

// What a symbolic link, as in /dev/serial/by-id, leads to: the library knows ports by their own
// names only.
std::string BehindLinks(const std::string& path) {
  std::error_code nowhere;
  const auto real = std::filesystem::canonical(path, nowhere);
  return nowhere ? path : real.string();
}

// What went wrong in the library's last call, which returned this.
std::string WhyOf(sp_return result) {
  switch (result) {
    case SP_ERR_FAIL:
      return std::strerror(sp_last_error_code());
    case SP_ERR_SUPP:
      return "not supported";
    case SP_ERR_MEM:
      return "no memory";
    default:
      return "invalid argument";
  }
}

std::string WhyNotOpened(const std::string& path, sp_return result) {
  switch (result == SP_ERR_FAIL ? sp_last_error_code() : 0) {
    case EACCES:
      return fmt::format("{}: {}", path, kNoPortPermission);
    case ENOENT:
    case ENODEV:
    case ENXIO:
      return fmt::format("{}: nothing is connected there", path);
    case EBUSY:
      return fmt::format("{}: in use by another program", path);
    default:
      return fmt::format("{}: cannot be opened: {}", path, WhyOf(result));
  }
}

// The setting that could not be made and why, if any.
std::optional<std::string> Configure(sp_port* port, const SerialSettings& s) {
  const sp_parity parity = s.parity == SerialSettings::Parity::kNone   ? SP_PARITY_NONE
                           : s.parity == SerialSettings::Parity::kEven ? SP_PARITY_EVEN
                                                                       : SP_PARITY_ODD;
  const sp_flowcontrol flow = s.flow == SerialSettings::Flow::kNone     ? SP_FLOWCONTROL_NONE
                              : s.flow == SerialSettings::Flow::kRtsCts ? SP_FLOWCONTROL_RTSCTS
                                                                        : SP_FLOWCONTROL_XONXOFF;
  sp_return result = SP_OK;
  const auto failed = [&](sp_return of_call) { return (result = of_call) != SP_OK; };
  const auto because = [&](const std::string& setting) {
    return fmt::format("{}: {}", setting, WhyOf(result));
  };
  // 0 baud would hang up.
  if (failed(s.baud > 0 ? sp_set_baudrate(port, s.baud) : SP_ERR_ARG)) {
    return because(fmt::format("{} baud", s.baud));
  }
  if (failed(sp_set_bits(port, 8))) return because("8 data bits");
  if (failed(sp_set_parity(port, parity))) return because("this parity");
  if (failed(sp_set_stopbits(port, s.stop_bits))) {
    return because(fmt::format("{} stop bits", s.stop_bits));
  }
  // Flow control sets the lines it uses, so those it leaves alone come afterwards.
  if (failed(sp_set_flowcontrol(port, flow))) return because("this flow control");
  if (failed(sp_set_dtr(port, s.dtr ? SP_DTR_ON : SP_DTR_OFF))) return because("DTR");
  if (s.flow == SerialSettings::Flow::kRtsCts) return std::nullopt;
  if (failed(sp_set_rts(port, s.rts ? SP_RTS_ON : SP_RTS_OFF))) return because("RTS");
  return std::nullopt;
}

}  // namespace

struct SerialPort::Handle {
  sp_port* port = nullptr;
  bool open = false;

  Handle() = default;
  Handle(const Handle&) = delete;
  Handle& operator=(const Handle&) = delete;
  ~Handle() {
    if (open) sp_close(port);
    sp_free_port(port);
  }

  int descriptor() const {
    int fd = -1;
    sp_get_port_handle(port, &fd);
    return fd;
  }
};

Result<std::vector<SerialPortInfo>> ListSerialPorts() {
  sp_port** ports = nullptr;
  if (const sp_return result = sp_list_ports(&ports); result != SP_OK) {
    return Refused(fmt::format("serial ports cannot be listed: {}", WhyOf(result)));
  }
  std::vector<SerialPortInfo> infos;
  for (sp_port** port = ports; *port != nullptr; ++port) infos.push_back(InfoOf(*port));
  sp_free_port_list(ports);
  std::sort(infos.begin(), infos.end(),
            [](const SerialPortInfo& a, const SerialPortInfo& b) { return a.path < b.path; });
  return infos;
}

Result<std::unique_ptr<SerialPort>> SerialPort::Open(const SerialSettings& settings) {
  const Result<std::string> path = PathOf(settings.port);
  if (!path) return path.error();
  auto handle = std::make_unique<Handle>();
  if (sp_get_port_by_name(path->c_str(), &handle->port) != SP_OK &&
      sp_get_port_by_name(BehindLinks(*path).c_str(), &handle->port) != SP_OK) {
    return Refused(
        fmt::format("{}: no such serial port; gonio devices lists those there are", *path));
  }
  if (const sp_return result = sp_open(handle->port, SP_MODE_READ_WRITE); result != SP_OK) {
    return Refused(WhyNotOpened(*path, result));
  }
  handle->open = true;
  if (flock(handle->descriptor(), LOCK_EX | LOCK_NB) != 0) {
    return Refused(fmt::format("{}: in use by another program", *path));
  }
  if (const auto refused = Configure(handle->port, settings)) {
    return Refused(fmt::format("{}: cannot have {}", *path, *refused));
  }
  std::unique_ptr<SerialPort> port(new SerialPort(*path, std::move(handle)));
  if (const Result<void> discarded = port->DiscardInput(); !discarded) return discarded.error();
  return port;
}

SerialPort::SerialPort(std::string name, std::unique_ptr<Handle> handle)
    : name_(std::move(name)), handle_(std::move(handle)) {}

SerialPort::~SerialPort() = default;

Error SerialPort::Gone() {
  gone_ = true;
  return {ErrorCode::kDisconnected, fmt::format("{}: disconnected", name_)};
}

Result<void> SerialPort::WaitFor(short events, const Deadline& deadline, const char* doing) {
  while (!gone_) {
    pollfd ready{.fd = handle_->descriptor(), .events = events, .revents = 0};
    const int count = poll(&ready, 1, deadline.MillisecondsLeft());
    if (count < 0 && errno == EINTR) continue;
    if (count < 0 || (ready.revents & (POLLERR | POLLHUP | POLLNVAL)) != 0) break;
    if (count > 0) return {};
    return TooLate(deadline, doing);
  }
  return Gone();
}

Error SerialPort::TooLate(const Deadline& deadline, const char* doing) const {
  return {ErrorCode::kTimeout,
          fmt::format("{}: {} within {:.3g} s", name_, doing, deadline.limit().count())};
}

Result<void> SerialPort::Write(std::string_view bytes, Seconds limit) {
  const Deadline deadline(limit);
  constexpr const char* kDoing = "not all bytes were taken";
  while (!gone_) {
    const sp_return taken = sp_nonblocking_write(handle_->port, bytes.data(), bytes.size());
    if (taken < 0) break;
    bytes.remove_prefix(static_cast<std::size_t>(taken));
    if (bytes.empty()) return {};
    // Room that is announced need not be there.
    if (deadline.Left() <= Seconds(0)) return TooLate(deadline, kDoing);
    if (const Result<void> ready = WaitFor(POLLOUT, deadline, kDoing); !ready) return ready;
  }
  return Gone();
}

Result<std::string> SerialPort::Read(std::size_t most, Seconds limit) {
  const Deadline deadline(limit);
  constexpr const char* kDoing = "no answer";
  std::string bytes(most, '\0');
  while (true) {
    const Result<void> ready = WaitFor(POLLIN, deadline, kDoing);
    if (!ready) return ready.error();
    const sp_return count = sp_nonblocking_read(handle_->port, bytes.data(), bytes.size());
    if (count > 0) {
      bytes.resize(static_cast<std::size_t>(count));
      return bytes;
    }
    // Nothing to read although there was: as a rule the far end went.
    if (count < 0 || sp_input_waiting(handle_->port) < 0) return Gone();
    if (deadline.Left() <= Seconds(0)) return TooLate(deadline, kDoing);
  }
}

Result<void> SerialPort::DiscardInput() {
  if (gone_ || sp_flush(handle_->port, SP_BUF_INPUT) != SP_OK) return Gone();
  return {};
}

}  // namespace gonio
