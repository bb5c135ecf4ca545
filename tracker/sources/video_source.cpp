// SPDX-License-Identifier: Apache-2.0
#include "tracker/sources/video_source.h"

#include <atomic>
#include <cmath>
#include <filesystem>

#include "common/base/clock.h"
#include "common/base/errors.h"
#include "common/base/format.h"
#include "tracker/sources/stream_address.h"
#include "tracker/sources/stream_source.h"
#include "tracker/sources/video_decoder.h"
#include "tracker/sources/video_device.h"

namespace sheen {
namespace {

constexpr double kLeastShare = 0.9;  ///< of the announced frames: rates that vary make estimates of a few percent

class VideoDeviceSource : public FrameSource {
 public:
  VideoDeviceSource(const std::string& path, const SourceSettings& settings)
      : path_(path),
        feed_([path, settings] { return std::make_unique<VideoDevice>(path, settings); },
              {.name = "video device " + path}) {}

  /// What the device is set to counts as an epoch: a device that comes back is set again.
  std::optional<Frame> next(std::chrono::milliseconds timeout) override {
    std::optional<Frame> frame = feed_.next(timeout);
    if (!frame) return frame;
    Exposure& now = frame->exposure;
    if (epoch_ == 0 || now.exposure_s != exposure_s_) ++epoch_;
    exposure_s_ = now.exposure_s;
    now.config_epoch = epoch_;
    return frame;
  }
  SourceState state() const override { return feed_.state(); }
  SourceStats stats() const override { return feed_.stats(); }
  bool live() const override { return true; }
  bool compressed() const override { return true; }  // most devices send MJPEG, and do not say so here
  std::string message() const override {
    const std::string name = "video device " + path_;
    switch (state()) {
      case SourceState::kStarting:
        return name + " is open, no frame yet";
      case SourceState::kLive:
        return name + " delivers";
      default:
        const std::string why = feed_.trouble();
        return why.empty() ? name + " has stopped delivering; check its cable" : why;
    }
  }

 private:
  const std::string path_;
  DeviceFeed feed_;
  double exposure_s_ = 0;
  std::uint32_t epoch_ = 0;
};

class VideoFileSource : public FrameSource {
 public:
  VideoFileSource(const std::string& path, const SourceSettings& settings);

  std::optional<Frame> next(std::chrono::milliseconds timeout) override;
  SourceState state() const override { return state_; }
  SourceStats stats() const override { return {.frames = frames_}; }
  bool live() const override { return false; }
  std::string message() const override {
    return path_ + (ended() ? " has ended" : ", frame " + std::to_string(frames_.load()));
  }
  std::string remarks() const override { return decoder_->warning(); }
  bool compressed() const override { return decoder_->lossy(); }

 private:
  void check(const SourceSettings& settings) const;
  [[noreturn]] void fail(const std::string& what) const;
  void end();

  const std::string path_;
  std::unique_ptr<VideoDecoder> decoder_;
  Exposure exposure_;
  std::atomic<std::uint64_t> frames_ = 0;
  std::atomic<SourceState> state_ = SourceState::kStarting;
};

VideoFileSource::VideoFileSource(const std::string& path, const SourceSettings& settings) : path_(path) {
  if (!std::filesystem::exists(path)) throw FileError(path, "does not exist");
  decoder_ = std::make_unique<VideoDecoder>(path);
  check(settings);
  exposure_.exposure_s = settings.exposure_us * 1e-6;
}

/// Nothing of a file can be set: what is asked for must be what it has.
void VideoFileSource::check(const SourceSettings& settings) const {
  const int width = decoder_->width(), height = decoder_->height();
  if (settings.width > 0 && (width != settings.width || height != settings.height))
    throw ConfigError(path_ + " has " + format("%d x %d", width, height) +
                      " pixels, but the configuration's [camera] is " +
                      format("%d x %d", settings.width, settings.height));
  const double rate_hz = decoder_->frame_rate_hz();
  if (settings.frame_rate_hz > 0 && !holds(settings.frame_rate_hz, rate_hz, 0))
    throw ConfigError(path_ + ": source.frame_rate_hz: asked " +
                      format("%g, the file has %g", settings.frame_rate_hz, rate_hz) + "; leave it out");
  const auto refuse = [&](bool asked, const char* key) {
    if (asked) throw ConfigError(path_ + ": source." + key + " cannot be set of a video file; leave it out");
  };
  refuse(settings.gain_db > 0, "gain_db");
  refuse(settings.black_level > 0, "black_level");
  refuse(settings.white_balance[0] > 0, "white_balance");
  refuse(!settings.pixel_format.empty() && settings.pixel_format != "RGB8", "pixel_format");
}

void VideoFileSource::fail(const std::string& what) const {
  throw FileError(path_, "frame " + std::to_string(frames_) + ": " + what);
}

/// The end of a file is expected, within what its header may be wrong by.
void VideoFileSource::end() {
  state_ = SourceState::kEnded;
  const double announced = decoder_->announced_frames();
  if (static_cast<double>(frames_) < kLeastShare * announced)
    fail("the video ends too early; its header states " + std::to_string(std::llround(announced)) +
         " frames. Is the file whole?");
}

std::optional<Frame> VideoFileSource::next(std::chrono::milliseconds) {
  if (ended()) return std::nullopt;
  std::optional<VideoPicture> picture = decoder_->next();
  if (!picture) {
    end();
    return std::nullopt;
  }
  Frame frame;
  frame.camera_frame_id = frames_++;
  frame.times.grabbed_ns = steady_now_ns();
  frame.times.device_ns = picture->time_ns.value_or(0);
  frame.exposure = exposure_;
  frame.image = std::move(picture->image);
  state_ = SourceState::kLive;
  return frame;
}

}  // namespace

std::unique_ptr<FrameSource> open_video(const std::string& path, const SourceSettings& settings) {
  if (is_stream_address(path)) return open_stream(path, settings);
  if (is_video_device(path)) return std::make_unique<VideoDeviceSource>(path, settings);
  return std::make_unique<VideoFileSource>(path, settings);
}

}  // namespace sheen
