// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>

#include "tracker/sources/frame_source.h"
#include "tracker/sources/source_uri.h"

namespace sheen {

/// A V4L2 device (/dev/videoN), the address of a live stream (`open_stream`), or a video file. Frames are sRGB.
///
/// A device is set up and read back as VideoDevice does. It may be unplugged: missing frames are noticed within 200 ms
/// (or two frame periods, if those are longer), it is opened again by a worker, and goes on delivering.
///
/// A file has one size and rate: others that are asked for are refused. Nobody knows its exposure: the one asked for is
/// taken to be true, and not locked. Its `next` throws FileError for a file that breaks off.
///
/// Throws DeviceError, FileError, or ConfigError for a file that is not as it is asked for.
std::unique_ptr<FrameSource> open_video(const std::string& path, const SourceSettings& settings);

}  // namespace sheen
