// SPDX-License-Identifier: Apache-2.0
#include "tracker/sources/video_device.h"

#include <fcntl.h>
#include <linux/videodev2.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <cerrno>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <opencv2/core.hpp>
#include <opencv2/videoio.hpp>

#include "common/base/clock.h"
#include "common/base/errors.h"
#include "common/base/format.h"
#include "tracker/sources/video_image.h"

namespace sheen {
namespace {

constexpr const char* kOnlyFormat = "RGB8";

/// The device's controls, beside the stream.
class ControlChannel {
 public:
  explicit ControlChannel(const std::string& path) : fd_(::open(path.c_str(), O_RDWR | O_NONBLOCK | O_CLOEXEC)) {}
  ~ControlChannel() {
    if (fd_ >= 0) ::close(fd_);
  }
  ControlChannel(const ControlChannel&) = delete;
  ControlChannel& operator=(const ControlChannel&) = delete;

  bool open() const { return fd_ >= 0; }
  DeviceCall call() const {
    return [fd = fd_](unsigned long request, void* argument) {
      int result = 0;
      do result = ::ioctl(fd, request, argument);
      while (result != 0 && errno == EINTR);
      return result;
    };
  }

 private:
  int fd_;
};

bool captures_video(const DeviceCall& call) {
  v4l2_capability capability{};
  if (call(VIDIOC_QUERYCAP, &capability) != 0) return false;
  const std::uint32_t can =
      capability.capabilities & V4L2_CAP_DEVICE_CAPS ? capability.device_caps : capability.capabilities;
  return can & V4L2_CAP_VIDEO_CAPTURE;
}

}  // namespace

struct VideoDevice::Impl {
  std::string path;
  cv::VideoCapture capture;
  std::vector<LockedFeature> locks;
  Exposure exposure;
  double frame_rate_hz = 0;

  [[noreturn]] void fail(const std::string& what) const { throw DeviceError("video device " + path + " " + what); }
  void set_up(const DeviceCall& call, const SourceSettings& settings);
  void set_size(int width, int height);
  void set_frame_rate(double asked_hz);
};

VideoDevice::VideoDevice(const std::string& path, const SourceSettings& settings) : impl_(std::make_unique<Impl>()) {
  impl_->path = path;
  if (!std::filesystem::exists(path)) impl_->fail("does not exist; plug the camera in");
  const ControlChannel controls(path);
  if (!controls.open()) impl_->fail(std::string("cannot be opened: ") + std::strerror(errno));
  if (!captures_video(controls.call())) impl_->fail("is no V4L2 camera; /dev/video0, /dev/video1, ... may be");
  if (!impl_->capture.open(path, cv::CAP_V4L2)) impl_->fail("cannot be opened; is it in use?");
  impl_->set_up(controls.call(), settings);
}

VideoDevice::~VideoDevice() = default;

void VideoDevice::Impl::set_size(int width, int height) {
  capture.set(cv::CAP_PROP_FRAME_WIDTH, width);
  capture.set(cv::CAP_PROP_FRAME_HEIGHT, height);
  const int got_width = static_cast<int>(capture.get(cv::CAP_PROP_FRAME_WIDTH));
  const int got_height = static_cast<int>(capture.get(cv::CAP_PROP_FRAME_HEIGHT));
  locks.push_back({"size", format("%d x %d", width, height), format("%d x %d", got_width, got_height),
                   got_width == width && got_height == height});
}

void VideoDevice::Impl::set_frame_rate(double asked_hz) {
  if (asked_hz > 0) capture.set(cv::CAP_PROP_FPS, asked_hz);
  frame_rate_hz = capture.get(cv::CAP_PROP_FPS);
  if (!(frame_rate_hz > 0) || !std::isfinite(frame_rate_hz)) frame_rate_hz = 0;
  if (asked_hz > 0)
    locks.push_back(
        {"frame rate", format("%g Hz", asked_hz), format("%g Hz", frame_rate_hz), holds(asked_hz, frame_rate_hz, 0)});
}

void VideoDevice::Impl::set_up(const DeviceCall& call, const SourceSettings& settings) {
  if (settings.width > 0) set_size(settings.width, settings.height);
  set_frame_rate(settings.frame_rate_hz);
  if (!settings.pixel_format.empty())
    locks.push_back({"pixel_format", settings.pixel_format, kOnlyFormat, settings.pixel_format == kOnlyFormat});
  const VideoLocks controls = lock_video_device(call, settings);
  locks.insert(locks.end(), controls.features.begin(), controls.features.end());
  if (const std::string failures = lock_failures(locks); !failures.empty())
    fail("does not stay as it is set: " + failures);
  exposure = {.exposure_s = controls.exposure_s, .locked = controls.exposure_s > 0};
}

std::optional<Frame> VideoDevice::read() {
  cv::Mat bgr;
  if (!impl_->capture.read(bgr)) return std::nullopt;
  Frame frame;
  frame.times.grabbed_ns = steady_now_ns();
  const double taken_ms = impl_->capture.get(cv::CAP_PROP_POS_MSEC);
  frame.times.device_ns = taken_ms > 0 ? std::llround(taken_ms * 1e6) : frame.times.grabbed_ns;
  frame.exposure = impl_->exposure;
  std::optional<RawImage> image = image_of_video(bgr);
  frame.complete = image.has_value();
  if (image) frame.image = *std::move(image);
  return frame;
}

double VideoDevice::frame_rate_hz() const {
  return impl_->frame_rate_hz;
}

const std::vector<LockedFeature>& VideoDevice::locks() const {
  return impl_->locks;
}

bool is_video_device(const std::string& path) {
  return path.starts_with("/dev/");
}

}  // namespace sheen
