// SPDX-License-Identifier: Apache-2.0
#include "tracker/sources/video_source.h"

#include <atomic>
#include <cmath>
#include <filesystem>
#include <opencv2/imgproc.hpp>
#include <opencv2/videoio.hpp>

#include "common/errors.h"

namespace sheen {

struct VideoSource::Impl {
  std::string path;
  bool device = false;
  cv::VideoCapture capture;
  std::atomic<std::uint64_t> frames = 0;
  std::atomic<SourceState> state = SourceState::kStarting;
};

VideoSource::VideoSource(const std::string& path) : impl_(std::make_unique<Impl>()) {
  impl_->path = path;
  impl_->device = path.starts_with("/dev/");
  if (!std::filesystem::exists(path)) {
    if (impl_->device) throw DeviceError("video device " + path + " does not exist; plug the camera in");
    throw FileError(path, "does not exist");
  }
  const bool opened = impl_->device ? impl_->capture.open(path, cv::CAP_V4L2) : impl_->capture.open(path);
  if (!opened && impl_->device) throw DeviceError("video device " + path + " cannot be opened; is it in use?");
  if (!opened) throw FileError(path, "is no video that can be read");
}

VideoSource::~VideoSource() = default;

std::optional<Frame> VideoSource::next(std::chrono::milliseconds) {
  cv::Mat bgr, rgb;
  if (state() == SourceState::kEnded) return std::nullopt;
  if (!impl_->capture.read(bgr) || bgr.type() != CV_8UC3) {
    impl_->state = SourceState::kEnded;
    return std::nullopt;
  }
  cv::cvtColor(bgr, rgb, cv::COLOR_BGR2RGB);
  Frame frame;
  frame.camera_frame_id = impl_->frames++;
  frame.times.grabbed_ns = steady_ns();
  const double played_ms = impl_->capture.get(cv::CAP_PROP_POS_MSEC);
  frame.times.device_ns = impl_->device ? frame.times.grabbed_ns : std::llround(played_ms * 1e6);
  frame.image = {.format = PixelFormat::kRGB8,
                 .transfer = Transfer::kSrgb,
                 .width = rgb.cols,
                 .height = rgb.rows,
                 .stride = std::size_t(rgb.cols) * 3,
                 .bytes = std::vector<std::uint8_t>(rgb.data, rgb.data + rgb.total() * 3)};
  impl_->state = SourceState::kLive;
  return frame;
}

SourceState VideoSource::state() const {
  return impl_->state;
}
std::string VideoSource::message() const {
  return impl_->path + (ended() ? " has ended" : ", frame " + std::to_string(impl_->frames.load()));
}
SourceStats VideoSource::stats() const {
  return {.frames = impl_->frames};
}
bool VideoSource::live() const {
  return impl_->device;
}

}  // namespace sheen
