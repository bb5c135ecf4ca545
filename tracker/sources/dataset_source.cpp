// SPDX-License-Identifier: Apache-2.0
#include "tracker/sources/dataset_source.h"
#include "common/base/clock.h"

namespace sheen {

DatasetSource::DatasetSource(const std::filesystem::path& folder)
    : dataset_(load_dataset(folder)), session_("dataset:" + dataset_.hash) {}

std::optional<Frame> DatasetSource::next(std::chrono::milliseconds) {
  if (ended()) return std::nullopt;
  Frame frame;
  frame.given = read_capture(dataset_, next_view_);
  frame.camera_frame_id = frame.given->camera_frame_id;
  frame.exposure = frame.given->exposure;
  frame.times.grabbed_ns = steady_now_ns();
  ++next_view_;
  return frame;
}

SourceState DatasetSource::state() const {
  return next_view_ < dataset_.views.size() ? SourceState::kLive : SourceState::kEnded;
}

std::string DatasetSource::message() const {
  return "image " + std::to_string(next_view_) + " of " + std::to_string(dataset_.views.size());
}

}  // namespace sheen
