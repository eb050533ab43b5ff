// SPDX-License-Identifier: Apache-2.0
#include "drivers/genicam_list.h"

#include <arpa/inet.h>
#include <arv.h>

#include <memory>
#include <string_view>

#include "drivers/genicam_features.h"

namespace gonio {
namespace {

struct Unref {
  void operator()(void* object) const { g_object_unref(object); }
};

std::string TextOf(const char* text) { return text ? text : ""; }

// Leaves the others out, and takes them in again at its end.
class OnlyInterface {
 public:
  explicit OnlyInterface(std::string_view wanted) {
    for (unsigned i = 0; i < arv_get_n_interfaces(); ++i) {
      const std::string id = TextOf(arv_get_interface_id(i));
      if (id == wanted || id == "Fake") continue;  // the latter is off unless somebody wants it
      arv_disable_interface(id.c_str());
      disabled_.push_back(id);
    }
  }
  ~OnlyInterface() {
    for (const std::string& id : disabled_) arv_enable_interface(id.c_str());
  }
  OnlyInterface(const OnlyInterface&) = delete;
  OnlyInterface& operator=(const OnlyInterface&) = delete;

 private:
  std::vector<std::string> disabled_;
};

std::vector<GenicamCameraInfo> List(const std::string& protocol) {
  const std::lock_guard lock(GenicamListMutex());
  const OnlyInterface only(protocol);
  arv_update_device_list();
  std::vector<GenicamCameraInfo> cameras;
  for (unsigned i = 0; i < arv_get_n_devices(); ++i) {
    GenicamCameraInfo info;
    info.protocol = TextOf(arv_get_device_protocol(i));
    if (info.protocol != protocol) continue;
    info.vendor = TextOf(arv_get_device_vendor(i));
    info.model = TextOf(arv_get_device_model(i));
    info.serial = TextOf(arv_get_device_serial_nbr(i));
    info.id = TextOf(arv_get_device_id(i));
    if (protocol == "GigEVision") info.address = TextOf(arv_get_device_address(i));
    cameras.push_back(info);
  }
  return cameras;
}

}  // namespace

std::mutex& GenicamListMutex() {
  static std::mutex mutex;
  return mutex;
}

std::vector<GenicamCameraInfo> ListUsbCameras() { return List("USB3Vision"); }
std::vector<GenicamCameraInfo> SearchGigeCameras() { return List("GigEVision"); }

Result<GenicamCameraInfo> AskGigeCamera(const std::string& address) {
  in_addr unused{};
  // Aravis would look for anything else all over the network.
  if (inet_pton(AF_INET, address.c_str(), &unused) != 1) {
    return Error{ErrorCode::kRefused, address + " is no IPv4 address"};
  }
  const std::lock_guard lock(GenicamListMutex());
  GError* error = nullptr;
  const std::unique_ptr<ArvCamera, Unref> camera(arv_camera_new(address.c_str(), &error));
  if (error || !camera) {
    return Error{ErrorCode::kRefused, GenicamError(error, "no camera at " + address).message};
  }
  ArvDevice* device = arv_camera_get_device(camera.get());
  const GenicamFeatures features(device);
  const auto text = [&](std::initializer_list<const char*> names) {
    const auto value = features.Text(features.FirstOf(names));
    return value ? *value : "";
  };
  GenicamCameraInfo info;
  info.protocol = "GigEVision";
  info.vendor = text({"DeviceVendorName"});
  info.model = text({"DeviceModelName"});
  info.serial = text({"DeviceSerialNumber", "DeviceID"});
  info.id = address;
  info.address = address;
  info.taken = ARV_IS_GV_DEVICE(device) && !arv_gv_device_is_controller(ARV_GV_DEVICE(device));
  return info;
}

}  // namespace gonio
