// SPDX-License-Identifier: Apache-2.0
#include "tracker/sources/aravis_devices.h"

#include <arv.h>

namespace sheen {
namespace {

std::string text(const char* value) {
  return value ? value : "";
}

}  // namespace

std::vector<CameraDevice> discover_cameras() {
  arv_update_device_list();
  std::vector<CameraDevice> devices;
  for (unsigned i = 0; i < arv_get_n_devices(); ++i)
    devices.push_back({.id = text(arv_get_device_id(i)),
                       .vendor = text(arv_get_device_vendor(i)),
                       .model = text(arv_get_device_model(i)),
                       .serial = text(arv_get_device_serial_nbr(i)),
                       .protocol = text(arv_get_device_protocol(i)),
                       .address = text(arv_get_device_address(i))});
  return devices;
}

}  // namespace sheen
