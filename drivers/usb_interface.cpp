// SPDX-License-Identifier: Apache-2.0
#include "drivers/usb_interface.h"

#include <fmt/format.h>
#include <libusb.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <tuple>
#include <utility>

#include "drivers/permission.h"

namespace gonio {
namespace {

Error Refused(std::string message) { return {ErrorCode::kRefused, std::move(message)}; }

// Of a limit above 0, which libusb takes for "for ever".
unsigned Milliseconds(Seconds limit) {
  constexpr double kMost = 1e9;
  return static_cast<unsigned>(std::clamp(std::ceil(1000 * limit.count()), 1.0, kMost));
}

class Context {
 public:
  static Result<std::unique_ptr<Context>> Made() {
    libusb_context* context = nullptr;
    if (const int result = libusb_init(&context); result != LIBUSB_SUCCESS) {
      return Refused(fmt::format("USB cannot be used: {}", libusb_strerror(result)));
    }
    return std::unique_ptr<Context>(new Context(context));
  }
  ~Context() { libusb_exit(context_); }
  Context(const Context&) = delete;
  Context& operator=(const Context&) = delete;
  libusb_context* get() const { return context_; }

 private:
  explicit Context(libusb_context* context) : context_(context) {}
  libusb_context* const context_;
};

using Device = std::unique_ptr<libusb_device, decltype(&libusb_unref_device)>;
using Opened = std::unique_ptr<libusb_device_handle, decltype(&libusb_close)>;

// An interface that a device has, and what is known of the device without claiming it.
struct Found {
  Device device{nullptr, libusb_unref_device};
  int interface = 0;
  std::uint8_t in = 0;  // addresses of the bulk endpoints
  std::uint8_t out = 0;
  std::size_t packet_bytes = 0;
  UsbDeviceInfo info;
  int opening = LIBUSB_SUCCESS;  // libusb's result
};

Opened Open(libusb_device* device, int* result) {
  libusb_device_handle* handle = nullptr;
  *result = libusb_open(device, &handle);
  return {handle, libusb_close};
}

std::string TextOf(libusb_device_handle* handle, std::uint8_t index) {
  unsigned char text[128];
  const int length =
      index == 0 ? 0 : libusb_get_string_descriptor_ascii(handle, index, text, sizeof text);
  return length > 0 ? std::string(text, text + length) : std::string();
}

std::string Name(const UsbDeviceInfo& info) {
  return fmt::format("USB {:04x}:{:04x}{}{}", info.vendor, info.product,
                     info.serial.empty() ? "" : " ", info.serial);
}

// The endpoints, if `setting` is one of this class.
bool Describe(const libusb_interface_descriptor& setting, const UsbClass& which, Found* found) {
  if (setting.bInterfaceClass != which.code || setting.bInterfaceSubClass != which.subclass) {
    return false;
  }
  found->interface = setting.bInterfaceNumber;
  for (int i = 0; i < setting.bNumEndpoints; ++i) {
    const libusb_endpoint_descriptor& endpoint = setting.endpoint[i];
    if ((endpoint.bmAttributes & LIBUSB_TRANSFER_TYPE_MASK) != LIBUSB_TRANSFER_TYPE_BULK) continue;
    if ((endpoint.bEndpointAddress & LIBUSB_ENDPOINT_IN) == 0) {
      found->out = endpoint.bEndpointAddress;
    } else {
      found->in = endpoint.bEndpointAddress;
      found->packet_bytes = endpoint.wMaxPacketSize & 0x7ff;
    }
  }
  return found->in != 0 && found->out != 0 && found->packet_bytes > 0;
}

std::optional<Found> Describe(libusb_device* device, const UsbClass& which) {
  libusb_device_descriptor descriptor = {};
  libusb_config_descriptor* config = nullptr;
  if (libusb_get_device_descriptor(device, &descriptor) != LIBUSB_SUCCESS ||
      libusb_get_active_config_descriptor(device, &config) != LIBUSB_SUCCESS) {
    return std::nullopt;
  }
  Found found;
  bool has = false;
  for (int i = 0; i < config->bNumInterfaces && !has; ++i) {
    const libusb_interface& interface = config->interface[i];
    has = interface.num_altsetting > 0 && Describe(interface.altsetting[0], which, &found);
  }
  libusb_free_config_descriptor(config);
  if (!has) return std::nullopt;
  found.device.reset(libusb_ref_device(device));
  found.info.vendor = descriptor.idVendor;
  found.info.product = descriptor.idProduct;
  if (const Opened handle = Open(device, &found.opening)) {
    found.info.serial = TextOf(handle.get(), descriptor.iSerialNumber);
    found.info.description = TextOf(handle.get(), descriptor.iProduct);
  }
  return found;
}

Result<std::vector<Found>> FindAll(const Context& context, const UsbClass& which) {
  libusb_device** devices = nullptr;
  const ssize_t count = libusb_get_device_list(context.get(), &devices);
  if (count < 0) {
    return Refused(
        fmt::format("USB devices cannot be listed: {}", libusb_strerror(static_cast<int>(count))));
  }
  std::vector<Found> all;
  for (ssize_t i = 0; i < count; ++i) {
    if (auto found = Describe(devices[i], which)) all.push_back(std::move(*found));
  }
  libusb_free_device_list(devices, 1);
  return all;
}

std::string Names(const std::vector<const Found*>& devices) {
  std::vector<std::string> names;
  for (const Found* found : devices) names.push_back(Name(found->info));
  std::sort(names.begin(), names.end());
  return fmt::format("{}", fmt::join(names, ", "));
}

std::string Name(const UsbSelection& selection) {
  std::vector<std::string> ids;
  for (const int product : selection.products) {
    ids.push_back(fmt::format("{:04x}:{:04x}", selection.vendor, product));
  }
  return fmt::format("USB {}{}{}", fmt::join(ids, " or "), selection.serial.empty() ? "" : " ",
                     selection.serial);
}

Error NoPermission(const std::string& name) {
  return Refused(fmt::format("{}: {}", name, kNoUsbPermission));
}

// The one that is wanted, or a reason why there is none.
Result<const Found*> Choose(const std::vector<Found>& all, const UsbSelection& selection,
                            const UsbClass& which) {
  std::vector<const Found*> everything;
  std::vector<const Found*> matching;
  const Found* closed = nullptr;
  for (const Found& found : all) {
    everything.push_back(&found);
    if (found.info.vendor != selection.vendor ||
        std::find(selection.products.begin(), selection.products.end(), found.info.product) ==
            selection.products.end()) {
      continue;
    }
    if (found.opening == LIBUSB_ERROR_ACCESS) closed = &found;
    if (selection.serial.empty() || found.info.serial == selection.serial) {
      matching.push_back(&found);
    }
  }
  if (matching.size() == 1) return matching.front();
  if (matching.size() > 1) {
    return Refused(fmt::format("{}: several are plugged in: {}; say which by its serial number",
                               Name(selection), Names(matching)));
  }
  if (closed != nullptr) return NoPermission(Name(closed->info));
  return Refused(fmt::format("{}: not plugged in; {} devices that are: {}", Name(selection),
                             which.what, all.empty() ? "none" : Names(everything)));
}

}  // namespace

struct UsbInterface::Handle {
  std::unique_ptr<Context> context;
  Opened device{nullptr, libusb_close};
  int interface = 0;
  std::uint8_t in = 0;
  std::uint8_t out = 0;
  std::size_t packet_bytes = 0;
  bool claimed = false;

  Handle() = default;
  Handle(const Handle&) = delete;
  Handle& operator=(const Handle&) = delete;
  ~Handle() {
    if (claimed) libusb_release_interface(device.get(), interface);
    device.reset();
  }
};

Result<std::vector<UsbDeviceInfo>> UsbInterface::List(const UsbClass& which) {
  const auto context = Context::Made();
  if (!context) return context.error();
  const auto all = FindAll(**context, which);
  if (!all) return all.error();
  std::vector<UsbDeviceInfo> infos;
  for (const Found& found : *all) infos.push_back(found.info);
  std::sort(infos.begin(), infos.end(), [](const UsbDeviceInfo& a, const UsbDeviceInfo& b) {
    return std::tie(a.vendor, a.product, a.serial) < std::tie(b.vendor, b.product, b.serial);
  });
  return infos;
}

Result<std::unique_ptr<UsbInterface>> UsbInterface::Open(const UsbSelection& selection,
                                                         const UsbClass& which) {
  auto context = Context::Made();
  if (!context) return context.error();
  const auto all = FindAll(**context, which);
  if (!all) return all.error();
  const auto chosen = Choose(*all, selection, which);
  if (!chosen) return chosen.error();
  const Found& found = **chosen;
  const std::string name = Name(found.info);
  auto handle = std::make_unique<Handle>();
  handle->context = std::move(context).value();
  handle->interface = found.interface;
  handle->in = found.in;
  handle->out = found.out;
  handle->packet_bytes = found.packet_bytes;
  int result = LIBUSB_SUCCESS;
  handle->device = gonio::Open(found.device.get(), &result);
  if (result == LIBUSB_SUCCESS) {
    libusb_set_auto_detach_kernel_driver(handle->device.get(), 1);
    result = libusb_claim_interface(handle->device.get(), found.interface);
    handle->claimed = result == LIBUSB_SUCCESS;
  }
  switch (result) {
    case LIBUSB_SUCCESS:
      return std::unique_ptr<UsbInterface>(new UsbInterface(std::move(handle), name));
    case LIBUSB_ERROR_ACCESS:
      return NoPermission(name);
    case LIBUSB_ERROR_BUSY:
      return Refused(fmt::format("{}: in use by another program", name));
    default:
      return Refused(fmt::format("{}: cannot be opened: {}", name, libusb_strerror(result)));
  }
}

UsbInterface::UsbInterface(std::unique_ptr<Handle> handle, std::string name)
    : handle_(std::move(handle)), name_(std::move(name)), packet_bytes_(handle_->packet_bytes) {}

UsbInterface::~UsbInterface() = default;

Error UsbInterface::Failed(int result, const char* doing, Seconds limit) {
  if (result == LIBUSB_ERROR_NO_DEVICE) gone_ = true;
  if (gone_) return {ErrorCode::kDisconnected, fmt::format("{}: disconnected", name_)};
  if (result == LIBUSB_ERROR_TIMEOUT) {
    return {ErrorCode::kTimeout,
            fmt::format("{}: {} within {:.3g} s", name_, doing, limit.count())};
  }
  const char* const why = result == LIBUSB_ERROR_PIPE       ? "the endpoint is stalled"
                          : result == LIBUSB_ERROR_OVERFLOW ? "more came than was asked for"
                                                            : libusb_strerror(result);
  return {ErrorCode::kProtocol, fmt::format("{}: {}: {}", name_, doing, why)};
}

Result<void> UsbInterface::Write(std::string_view bytes, Seconds limit) {
  constexpr const char* kDoing = "not all bytes were taken";
  if (gone_) return Failed(LIBUSB_ERROR_NO_DEVICE, kDoing, limit);
  if (limit <= Seconds(0)) return Failed(LIBUSB_ERROR_TIMEOUT, kDoing, limit);
  std::string copy(bytes);  // libusb's are not const
  int taken = 0;
  const int result = libusb_bulk_transfer(
      handle_->device.get(), handle_->out, reinterpret_cast<unsigned char*>(copy.data()),
      static_cast<int>(copy.size()), &taken, Milliseconds(limit));
  if (result != LIBUSB_SUCCESS) return Failed(result, kDoing, limit);
  return taken == static_cast<int>(copy.size()) ? Result<void>()
                                                : Failed(LIBUSB_ERROR_IO, kDoing, limit);
}

Result<std::string> UsbInterface::Read(std::size_t most, Seconds limit) {
  constexpr const char* kDoing = "no answer";
  if (gone_) return Failed(LIBUSB_ERROR_NO_DEVICE, kDoing, limit);
  if (limit <= Seconds(0)) return Failed(LIBUSB_ERROR_TIMEOUT, kDoing, limit);
  std::string bytes(most, '\0');
  int count = 0;
  const int result = libusb_bulk_transfer(handle_->device.get(), handle_->in,
                                          reinterpret_cast<unsigned char*>(bytes.data()),
                                          static_cast<int>(most), &count, Milliseconds(limit));
  if (result != LIBUSB_SUCCESS) return Failed(result, kDoing, limit);
  bytes.resize(static_cast<std::size_t>(count));
  return bytes;
}

Result<std::string> UsbInterface::Ask(std::uint8_t request, std::uint16_t value, About about,
                                      std::uint16_t most, Seconds limit) {
  constexpr const char* kDoing = "no answer to a class request";
  if (gone_) return Failed(LIBUSB_ERROR_NO_DEVICE, kDoing, limit);
  if (limit <= Seconds(0)) return Failed(LIBUSB_ERROR_TIMEOUT, kDoing, limit);
  const int recipient =
      about == About::kInterface ? LIBUSB_RECIPIENT_INTERFACE : LIBUSB_RECIPIENT_ENDPOINT;
  const int type = int{LIBUSB_ENDPOINT_IN} | int{LIBUSB_REQUEST_TYPE_CLASS} | recipient;
  const int index = about == About::kInterface ? handle_->interface
                    : about == About::kOut     ? handle_->out
                                               : handle_->in;
  std::string reply(most, '\0');
  const int result = libusb_control_transfer(handle_->device.get(), static_cast<std::uint8_t>(type),
                                             request, value, static_cast<std::uint16_t>(index),
                                             reinterpret_cast<unsigned char*>(reply.data()), most,
                                             Milliseconds(limit));
  if (result < 0) return Failed(result, kDoing, limit);
  reply.resize(static_cast<std::size_t>(result));
  return reply;
}

Result<void> UsbInterface::ClearHalt(About endpoint) {
  constexpr const char* kDoing = "a stalled endpoint stays so";
  if (gone_) return Failed(LIBUSB_ERROR_NO_DEVICE, kDoing, Seconds(0));
  const int result = libusb_clear_halt(handle_->device.get(),
                                       endpoint == About::kOut ? handle_->out : handle_->in);
  if (result != LIBUSB_SUCCESS) return Failed(result, kDoing, Seconds(0));
  return {};
}

}  // namespace gonio
