// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

namespace sheen {

/// A GigE Vision or USB3 Vision camera that answered a discovery.
struct CameraDevice {
  std::string id;  ///< what `aravis:ID` takes
  std::string vendor, model, serial;
  std::string protocol;  ///< "GigEVision", "USB3Vision"
  std::string address;   ///< IP address, or the USB device's identity
};

/// Broadcasts a discovery on every interface and waits for the answers (about a second).
std::vector<CameraDevice> discover_cameras();

}  // namespace sheen
