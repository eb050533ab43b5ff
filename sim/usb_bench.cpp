// SPDX-License-Identifier: Apache-2.0
#include "sim/usb_bench.h"

// Before what is defined by its macros.
#include <fmt/format.h>
#include <linux/usbdevice_fs.h>
#include <stdlib.h>
#include <sys/ioctl.h>
#include <termios.h>
#include <umockdev.h>
#include <unistd.h>

#include <cerrno>
#include <cstddef>
#include <cstring>
#include <map>
#include <string_view>
#include <utility>
#include <vector>

#include "core/error.h"
#include "sim/usb_host.h"

namespace gonio {
namespace {

constexpr std::size_t kSetupBytes = 8;

// Something that g_object_unref() is the end of.
struct Unref {
  void operator()(void* object) const { g_object_unref(object); }
};
struct UnrefData {
  void operator()(UMockdevIoctlData* data) const { umockdev_ioctl_data_unref(data); }
};
using Handler = std::unique_ptr<UMockdevIoctlBase, Unref>;
using Data = std::unique_ptr<UMockdevIoctlData, UnrefData>;

// A copy of the program's memory, which goes back to it when its call returns.
Data Resolve(UMockdevIoctlData* at, std::size_t offset, std::size_t size) {
  return Data(umockdev_ioctl_data_resolve(at, offset, size, nullptr));
}

template <typename T>
Data ArgumentOf(UMockdevIoctlClient* client) {
  return Resolve(umockdev_ioctl_client_get_arg(client), 0, sizeof(T));
}

template <typename T>
T* As(const Data& data) {
  return reinterpret_cast<T*>(data->data);
}

// The answer to a call: a value, or -1 and an errno.
gboolean Return(UMockdevIoctlClient* client, long value) {
  umockdev_ioctl_client_complete(client, value, 0);
  return TRUE;
}
gboolean ReturnError(UMockdevIoctlClient* client, int error) {
  if (error == 0) return Return(client, 0);
  umockdev_ioctl_client_complete(client, -1, error);
  return TRUE;
}

std::string Hex(std::string_view bytes) {
  std::string hex;
  for (const char c : bytes) hex += fmt::format("{:02X}", static_cast<unsigned char>(c));
  return hex;
}

void Add(UMockdevTestbed* testbed, const std::string& description) {
  GError* error = nullptr;
  if (umockdev_testbed_add_from_string(testbed, description.c_str(), &error) == FALSE) {
    const std::string why = error->message;
    g_error_free(error);
    throw ConfigError(fmt::format("cannot be plugged in: {}", why));
  }
}

void Attach(UMockdevTestbed* testbed, const std::string& node, UMockdevIoctlBase* handler) {
  GError* error = nullptr;
  if (umockdev_testbed_attach_ioctl(testbed, node.c_str(), handler, &error) == FALSE) {
    const std::string why = error->message;
    g_error_free(error);
    throw ConfigError(fmt::format("{} cannot be served: {}", node, why));
  }
}

std::string PlateAttributes(const UsbPlate& plate, int device_number) {
  return fmt::format(
      "E: DEVTYPE=usb_device\nE: SUBSYSTEM=usb\nA: busnum=1\\n\nA: devnum={}\\n\n"
      "A: idVendor={:04x}\\n\nA: idProduct={:04x}\\n\nA: manufacturer={}\\n\nA: product={}\\n\n"
      "A: serial={}\\n\nA: bConfigurationValue=1\\n\nA: speed=12\\n\n",
      device_number, plate.vendor, plate.product, plate.maker, plate.description, plate.serial);
}

// The calls that programs make on the node of a USB device, put to its host.
class UsbNode {
 public:
  UsbNode(UsbDouble* device, std::string node, std::string path)
      : device_(device), host_(device), node_(std::move(node)), path_(std::move(path)) {
    handler_.reset(umockdev_ioctl_base_new());
    g_signal_connect(handler_.get(), "handle-ioctl", G_CALLBACK(OnCall), this);
  }
  ~UsbNode() { g_signal_handlers_disconnect_by_data(handler_.get(), this); }

  UsbDouble* device() const { return device_; }
  UsbHost& host() { return host_; }
  const std::string& node() const { return node_; }
  const std::string& path() const { return path_; }
  UMockdevIoctlBase* handler() const { return handler_.get(); }

 private:
  static gboolean OnCall(UMockdevIoctlBase*, UMockdevIoctlClient* client, gpointer self) {
    return static_cast<UsbNode*>(self)->Call(client);
  }
  static void OnClosed(UMockdevIoctlClient* client, GParamSpec*, gpointer self) {
    if (umockdev_ioctl_client_get_connected(client) == FALSE) {
      static_cast<UsbNode*>(self)->Closed(client);
    }
  }

  gboolean Call(UMockdevIoctlClient* client);
  gboolean Submit(UMockdevIoctlClient* client);
  gboolean Reap(UMockdevIoctlClient* client);
  gboolean ToDriver(UMockdevIoctlClient* client);
  void Closed(UMockdevIoctlClient* client);

  struct Block {  // of a transfer, in the program's memory
    UMockdevIoctlClient* client;
    Data urb;
  };

  UsbDouble* const device_;
  UsbHost host_;
  const std::string node_;
  const std::string path_;
  Handler handler_;
  std::map<UsbHost::Ticket, Block> blocks_;  // by where they are in the program
  std::map<UMockdevIoctlClient*, gulong> known_;
};

gboolean UsbNode::Call(UMockdevIoctlClient* client) {
  if (!known_.contains(client)) {
    known_[client] = g_signal_connect(client, "notify::connected", G_CALLBACK(OnClosed), this);
  }
  switch (umockdev_ioctl_client_get_request(client)) {
    case USBDEVFS_GET_CAPABILITIES:
      *As<std::uint32_t>(ArgumentOf<std::uint32_t>(client)) = USBDEVFS_CAP_ZERO_PACKET |
                                                              USBDEVFS_CAP_NO_PACKET_SIZE_LIM |
                                                              USBDEVFS_CAP_REAP_AFTER_DISCONNECT;
      return ReturnError(client, host_.is_out() ? ENODEV : 0);
    case USBDEVFS_GETDRIVER: {
      const Data argument = ArgumentOf<usbdevfs_getdriver>(client);
      auto* const asked = As<usbdevfs_getdriver>(argument);
      const std::string driver = host_.DriverOf(asked->interface);
      driver.copy(asked->driver, USBDEVFS_MAXDRIVERNAME);
      return ReturnError(client, driver.empty() ? ENODATA : 0);
    }
    case USBDEVFS_DISCONNECT_CLAIM:
      return ReturnError(
          client,
          host_.Claim(client,
                      As<usbdevfs_disconnect_claim>(ArgumentOf<usbdevfs_disconnect_claim>(client))
                          ->interface,
                      true));
    case USBDEVFS_CLAIMINTERFACE:
      return ReturnError(client,
                         host_.Claim(client, *As<unsigned>(ArgumentOf<unsigned>(client)), false));
    case USBDEVFS_RELEASEINTERFACE:
      return ReturnError(client,
                         host_.Release(client, *As<unsigned>(ArgumentOf<unsigned>(client))));
    case USBDEVFS_IOCTL:
      return ToDriver(client);
    case USBDEVFS_CLEAR_HALT:
      return ReturnError(
          client,
          host_.ClearHalt(static_cast<std::uint8_t>(*As<unsigned>(ArgumentOf<unsigned>(client)))));
    case USBDEVFS_RESET:
      return ReturnError(client, host_.Reset());
    case USBDEVFS_SUBMITURB:
      return Submit(client);
    case USBDEVFS_REAPURB:
    case USBDEVFS_REAPURBNDELAY:
      return Reap(client);
    case USBDEVFS_DISCARDURB:
      return ReturnError(client, host_.Cancel(*reinterpret_cast<std::uintptr_t*>(
                                     umockdev_ioctl_client_get_arg(client)->data)));
    default:
      return ReturnError(client, ENOTTY);
  }
}

gboolean UsbNode::ToDriver(UMockdevIoctlClient* client) {
  const Data argument = ArgumentOf<usbdevfs_ioctl>(client);
  const auto* const call = As<usbdevfs_ioctl>(argument);
  const auto interface = static_cast<unsigned>(call->ifno);
  switch (static_cast<unsigned>(call->ioctl_code)) {
    case USBDEVFS_DISCONNECT:
      return ReturnError(client, host_.DetachSystemDriver(interface));
    case USBDEVFS_CONNECT: {
      const int error = host_.AttachSystemDriver(interface);
      return error == 0 ? Return(client, 1) : ReturnError(client, error);
    }
    default:
      return ReturnError(client, ENOTTY);
  }
}

gboolean UsbNode::Submit(UMockdevIoctlClient* client) {
  Data block = ArgumentOf<usbdevfs_urb>(client);
  const auto* const urb = As<usbdevfs_urb>(block);
  const bool control = urb->type == USBDEVFS_URB_TYPE_CONTROL;
  if (!control && urb->type != USBDEVFS_URB_TYPE_BULK) return ReturnError(client, EINVAL);
  const auto size = static_cast<std::size_t>(urb->buffer_length);
  const Data buffer = Resolve(block.get(), offsetof(usbdevfs_urb, buffer), size);
  UsbHost::Transfer transfer;
  transfer.kind = control ? UsbHost::Transfer::Kind::kControl : UsbHost::Transfer::Kind::kBulk;
  transfer.endpoint = urb->endpoint;
  const bool in = !control && (urb->endpoint & 0x80) != 0;
  if (!in && buffer) transfer.bytes.assign(reinterpret_cast<const char*>(buffer->data), size);
  transfer.room = control ? size - std::min(size, kSetupBytes) : in ? size : 0;
  const UsbHost::Ticket ticket = block->client_addr;
  const int error = host_.Submit(client, ticket, std::move(transfer));
  if (error == 0) blocks_[ticket] = {client, std::move(block)};
  return ReturnError(client, error);
}

gboolean UsbNode::Reap(UMockdevIoctlClient* client) {
  UsbHost::Ended ended;
  if (const int error = host_.Reap(client, &ended); error != 0) return ReturnError(client, error);
  const Data block = std::move(blocks_.extract(ended.ticket).mapped().urb);
  auto* const urb = As<usbdevfs_urb>(block);
  const bool control = urb->type == USBDEVFS_URB_TYPE_CONTROL;
  urb->status = ended.status;
  urb->actual_length = static_cast<int>(ended.bytes.size() + ended.sent);
  const Data buffer = Resolve(block.get(), offsetof(usbdevfs_urb, buffer),
                              static_cast<std::size_t>(urb->buffer_length));
  if (!ended.bytes.empty()) {
    std::memcpy(buffer->data + (control ? kSetupBytes : 0), ended.bytes.data(), ended.bytes.size());
  }
  umockdev_ioctl_data_set_ptr(ArgumentOf<void*>(client).get(), 0, block.get());
  return Return(client, 0);
}

void UsbNode::Closed(UMockdevIoctlClient* client) {
  const auto known = known_.find(client);
  if (known == known_.end()) return;
  g_signal_handler_disconnect(client, known->second);
  known_.erase(known);
  host_.ReleaseAll(client);
  std::erase_if(blocks_, [client](const auto& block) { return block.second.client == client; });
}

// A pseudo-terminal has no modem lines, which serial ports are asked for; all else it does.
gboolean OnSerialCall(UMockdevIoctlBase*, UMockdevIoctlClient* client, gpointer) {
  switch (umockdev_ioctl_client_get_request(client)) {
    case TIOCMGET:
      *As<int>(ArgumentOf<int>(client)) = TIOCM_DTR | TIOCM_RTS | TIOCM_CTS | TIOCM_DSR | TIOCM_CAR;
      return Return(client, 0);
    case TIOCMSET:
    case TIOCMBIS:
    case TIOCMBIC:
      return Return(client, 0);
    default: {
      int error = 0;
      const int result = umockdev_ioctl_client_execute(client, &error, nullptr);
      umockdev_ioctl_client_complete(client, result, error);
      return TRUE;
    }
  }
}

}  // namespace

class UsbBench::Impl {
 public:
  Impl() : testbed_(umockdev_testbed_new()) {
    gchar* const root = umockdev_testbed_get_root_dir(testbed_.get());
    root_ = root;
    g_free(root);
    serial_.reset(umockdev_ioctl_base_new());
    g_signal_connect(serial_.get(), "handle-ioctl", G_CALLBACK(OnSerialCall), nullptr);
  }
  ~Impl() {
    for (const auto& node : nodes_) {
      umockdev_testbed_detach_ioctl(testbed_.get(), node->node().c_str(), nullptr);
    }
    for (const auto& [node, paths] : serial_paths_) {
      umockdev_testbed_detach_ioctl(testbed_.get(), node.c_str(), nullptr);
    }
    // Ends the thread that calls the nodes.
    testbed_.reset();
  }

  void Plug(UsbDouble* device) {
    device->Reset();
    const int number = ++last_number_;
    const std::string name = fmt::format("bus/usb/001/{:03}", number);
    const std::string path = fmt::format("/devices/pci0000:00/usb1/1-{}", number);
    auto node = std::make_unique<UsbNode>(device, "/dev/" + name, path);
    // Before it appears, so that nobody finds it deaf.
    Attach(testbed_.get(), node->node(), node->handler());
    Add(testbed_.get(),
        fmt::format("P: {}\nN: {}\nE: DEVNAME=/dev/{}\nE: BUSNUM=001\nE: DEVNUM={:03}\n{}"
                    "H: descriptors={}\n",
                    path, name, name, number, PlateAttributes(device->plate(), number),
                    Hex(device->Descriptors())));
    nodes_.push_back(std::move(node));
  }

  void Unplug(const UsbDouble* device) {
    UsbNode& node = NodeOf(device);
    node.host().TakeOut();
    Remove(node.path());
    unlink(FileOf(node.node()).c_str());
  }

  void Plug(const SerialAdapter& adapter) {
    const std::string node = "/dev/" + adapter.node;
    if (serial_paths_.contains(node)) {
      throw ConfigError(fmt::format("{} is there already", node));
    }
    const int number = ++last_number_;
    const std::string device = fmt::format("/devices/pci0000:00/usb1/1-{}", number);
    const std::string interface = fmt::format("{}/1-{}:1.0", device, number);
    Attach(testbed_.get(), node, serial_.get());
    Add(testbed_.get(),
        fmt::format("P: {0}\n{1}\nP: {2}\nE: DEVTYPE=usb_interface\nE: SUBSYSTEM=usb\n\n"
                    "P: {2}/{3}\nE: SUBSYSTEM=usb-serial\n\n"
                    "P: {2}/{3}/tty/{3}\nE: DEVNAME=/dev/{3}\nE: SUBSYSTEM=tty\nA: dev=188:{4}\n"
                    "L: device=../../../{3}\n",
                    device, PlateAttributes(adapter.plate, number), interface, adapter.node,
                    number));
    const std::string file = FileOf(node);
    // The directory is there only once a device with a node of its own was plugged in.
    g_mkdir_with_parents((root_ + "/dev").c_str(), 0755);
    if (symlink(adapter.line.c_str(), file.c_str()) != 0) {
      throw ConfigError(
          fmt::format("{} cannot lead to {}: {}", node, adapter.line, std::strerror(errno)));
    }
    serial_paths_[node] = {fmt::format("{0}/{1}/tty/{1}", interface, adapter.node),
                           fmt::format("{}/{}", interface, adapter.node), interface, device};
  }

  void Unplug(const SerialAdapter& adapter) {
    const std::string node = "/dev/" + adapter.node;
    const auto path = serial_paths_.extract(node);
    if (path.empty()) return;
    umockdev_testbed_detach_ioctl(testbed_.get(), node.c_str(), nullptr);
    for (const std::string& part : path.mapped()) Remove(part);
    unlink(FileOf(node).c_str());
  }

  UsbNode& NodeOf(const UsbDouble* device) const {
    for (auto node = nodes_.rbegin(); node != nodes_.rend(); ++node) {
      if ((*node)->device() == device) return **node;
    }
    throw ConfigError("this device was never plugged in");
  }
  std::string FileOf(const std::string& node) const { return root_ + node; }

 private:
  void Remove(const std::string& path) {
    umockdev_testbed_remove_device(testbed_.get(), ("/sys" + path).c_str());
  }

  std::unique_ptr<UMockdevTestbed, Unref> testbed_;
  std::string root_;
  std::vector<std::unique_ptr<UsbNode>>
      nodes_;  // those taken out, too: programs may have them open
  Handler serial_;
  // By node: all that the adapter consists of, from the port up to the plug.
  std::map<std::string, std::vector<std::string>> serial_paths_;
  int last_number_ = 0;
};

bool UsbBench::SeenFromHere() {
  const char* const preload = getenv("LD_PRELOAD");
  return preload != nullptr && std::string_view(preload).find(kPreload) != std::string_view::npos;
}

UsbBench::UsbBench() : impl_(std::make_unique<Impl>()) {}
UsbBench::~UsbBench() = default;
void UsbBench::Plug(UsbDouble* device) { impl_->Plug(device); }
void UsbBench::Unplug(UsbDouble* device) { impl_->Unplug(device); }
void UsbBench::Plug(const SerialAdapter& adapter) { impl_->Plug(adapter); }
void UsbBench::Unplug(const SerialAdapter& adapter) { impl_->Unplug(adapter); }
bool UsbBench::HeldBySystem(const UsbDouble* device) const {
  return impl_->NodeOf(device).host().DriverOf(1) == "usbtmc";
}
std::string UsbBench::NodeFile(const UsbDouble* device) const {
  return impl_->FileOf(impl_->NodeOf(device).node());
}

}  // namespace gonio
