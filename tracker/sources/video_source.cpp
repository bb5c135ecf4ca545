// SPDX-License-Identifier: Apache-2.0
#include "tracker/sources/video_source.h"

#include <atomic>
#include <cmath>
#include <filesystem>
#include <opencv2/imgproc.hpp>
#include <opencv2/videoio.hpp>

#include "common/base/clock.h"
#include "common/base/errors.h"

namespace sheen {

namespace {
constexpr double kLeastShare = 0.9;  ///< of the announced frames: rates that vary make estimates of a few percent
}

struct VideoSource::Impl {
  std::string path;
  bool device = false;
  cv::VideoCapture capture;
  double announced = 0;  ///< frames that the file says it has; often an estimate, 0 where it says nothing
  std::atomic<std::uint64_t> frames = 0;

  [[noreturn]] void fail(const std::string& what) const;
  void end();
  std::atomic<SourceState> state = SourceState::kStarting;
};

void VideoSource::Impl::fail(const std::string& what) const {
  const std::string text = "frame " + std::to_string(frames) + ": " + what;
  if (device) throw DeviceError("video device " + path + ": " + text);
  throw FileError(path, text);
}

/// The end of a file is expected, within what its header may be wrong by; a device has none.
void VideoSource::Impl::end() {
  state = SourceState::kEnded;
  if (device) fail("the device has stopped delivering; check its cable");
  if (static_cast<double>(frames) < kLeastShare * announced)
    fail("the video ends too early; its header states " + std::to_string(std::llround(announced)) +
         " frames. Is the file whole?");
}

VideoSource::VideoSource(const std::string& path) : impl_(std::make_unique<Impl>()) {
  impl_->path = path;
  impl_->device = path.starts_with("/dev/");
  if (!std::filesystem::exists(path)) {
    if (impl_->device) throw DeviceError("video device " + path + " does not exist; plug the camera in");
    throw FileError(path, "does not exist");
  }
  const bool opened = impl_->device ? impl_->capture.open(path, cv::CAP_V4L2) : impl_->capture.open(path);
  if (!opened && impl_->device) throw DeviceError("video device " + path + " cannot be opened; is it in use?");
  if (!opened) throw FileError(path, "cannot be read as a video");
  if (!impl_->device) impl_->announced = impl_->capture.get(cv::CAP_PROP_FRAME_COUNT);
}

VideoSource::~VideoSource() = default;

std::optional<Frame> VideoSource::next(std::chrono::milliseconds) {
  cv::Mat bgr, rgb;
  if (state() == SourceState::kEnded) return std::nullopt;
  if (!impl_->capture.read(bgr)) {
    impl_->end();
    return std::nullopt;
  }
  if (bgr.type() != CV_8UC3) impl_->fail("is not an 8-bit colour image");
  cv::cvtColor(bgr, rgb, cv::COLOR_BGR2RGB);
  Frame frame;
  frame.camera_frame_id = impl_->frames++;
  frame.times.grabbed_ns = steady_now_ns();
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
