// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>

#include "tracker/sources/frame_source.h"
#include "tracker/sources/source_uri.h"

namespace sheen {

/// A live stream of the network as a camera (`NetworkStream`): it is connected to again when the connection ends, the
/// newest frame wins, and those that were overtaken are counted as missed. Nothing of it can be set, and nothing is
/// known of its exposure. Throws DeviceError where it cannot be opened, and ConfigError where anything but the size is
/// asked for or it has another one.
std::unique_ptr<FrameSource> open_stream(const std::string& address, const SourceSettings& settings);

}  // namespace sheen
