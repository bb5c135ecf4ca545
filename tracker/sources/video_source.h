// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "tracker/sources/frame_source.h"

namespace sheen {

/// A V4L2 device (/dev/videoN) or a video file. Frames are sRGB; their exposure is unknown and not locked.
class VideoSource : public FrameSource {
 public:
  explicit VideoSource(const std::string& path);  ///< throws DeviceError or FileError
  ~VideoSource() override;

  std::optional<Frame> next(std::chrono::milliseconds timeout) override;
  SourceState state() const override;
  std::string message() const override;
  SourceStats stats() const override;
  bool live() const override;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace sheen
