// SPDX-License-Identifier: Apache-2.0
#include "tracker/sources/dataset_source.h"

#include "common/base/clock.h"

namespace sheen {

std::optional<Frame> DatasetSource::next(std::chrono::milliseconds) {
  if (ended()) return std::nullopt;
  Frame frame;
  frame.given = images_.read(next_image_);
  frame.camera_frame_id = frame.given->camera_frame_id;
  frame.exposure = frame.given->exposure;
  frame.times.grabbed_ns = steady_now_ns();
  ++next_image_;
  return frame;
}

SourceState DatasetSource::state() const {
  return next_image_ < images_.size ? SourceState::kLive : SourceState::kEnded;
}

std::string DatasetSource::message() const {
  return "image " + std::to_string(next_image_) + " of " + std::to_string(images_.size);
}

}  // namespace sheen
