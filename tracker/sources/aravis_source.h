// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "tracker/sources/frame_source.h"
#include "tracker/sources/source_uri.h"

namespace sheen {

/// A GigE Vision or USB3 Vision camera that may be unplugged: missing frames are noticed within 200 ms (or two frame
/// periods, if those are longer; the camera's own loss-of-control notice takes 5 s), the connection is opened again by
/// a worker, and a camera that comes back goes on delivering. It begins to deliver with the first call of `next`: while
/// other cameras are still being opened, no frame is lost.
class AravisSource : public FrameSource {
 public:
  AravisSource(const std::string& id, const SourceSettings& settings);  ///< throws DeviceError
  ~AravisSource() override;

  std::optional<Frame> next(std::chrono::milliseconds timeout) override;
  SourceState state() const override;
  std::string message() const override;
  std::string remarks() const override;
  SourceStats stats() const override;
  bool live() const override { return true; }

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace sheen
