// SPDX-License-Identifier: Apache-2.0
// Video files that the test writes, a V4L2 device where the kernel has a loopback one, and what both rest on: controls
// that are set and read back, a device that hangs or is unplugged.
#include "tracker/sources/video_source.h"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <linux/videodev2.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <fstream>
#include <functional>
#include <map>
#include <new>
#include <opencv2/core.hpp>
#include <opencv2/videoio.hpp>
#include <stdexcept>
#include <thread>

#include "common/base/errors.h"
#include "common/base/files.h"
#include "tests/support/expect_error.h"
#include "tests/support/patience.h"
#include "tests/support/temp_folder.h"
#include "tracker/sources/device_feed.h"
#include "tracker/sources/video_controls.h"

namespace sheen {
namespace {

using std::chrono::milliseconds;
using ::testing::HasSubstr;
using Clock = std::chrono::steady_clock;

constexpr int kFrames = 24;
constexpr double kRate = 25;

/// Grey that rises from frame to frame; the left half is red.
cv::Mat picture(int i) {
  cv::Mat bgr(120, 160, CV_8UC3, cv::Scalar::all(8 * i + 20));
  bgr.colRange(0, 80).setTo(cv::Scalar(0, 0, 8 * i + 20));
  return bgr;
}

class VideoFile : public ::testing::Test {
 protected:
  VideoFile() {
    cv::VideoWriter video(file_, cv::VideoWriter::fourcc('F', 'F', 'V', '1'), kRate, {160, 120});
    EXPECT_TRUE(video.isOpened());
    for (int i = 0; i < kFrames; ++i) video.write(picture(i));
  }
  const TempFolder temp_;
  const std::string file_ = (temp_.path() / "hand.avi").string();
};

TEST_F(VideoFile, GivesEachFrameAsItWasWritten) {
  const auto source = open_video(file_, {.width = 160, .height = 120, .frame_rate_hz = kRate, .exposure_us = 4000});
  EXPECT_FALSE(source->live());
  EXPECT_FALSE(source->compressed()) << "FFV1 loses nothing";
  for (int i = 0; i < kFrames; ++i) {
    const auto frame = source->next(milliseconds(0));
    ASSERT_TRUE(frame) << i;
    EXPECT_EQ(frame->camera_frame_id, static_cast<std::uint64_t>(i));
    EXPECT_NEAR(static_cast<double>(frame->times.device_ns), i * 1e9 / kRate, 1e6);
    EXPECT_EQ(frame->image.width, 160);
    EXPECT_EQ(frame->image.height, 120);
    EXPECT_EQ(frame->image.transfer, Transfer::kSrgb);
    EXPECT_NEAR(frame->exposure.exposure_s, 0.004, 1e-12) << "what the person says of it";
    EXPECT_FALSE(frame->exposure.locked);
    const std::uint8_t *left = frame->image.bytes.data(), *right = left + 3 * 150;
    EXPECT_NEAR(left[0], 8 * i + 20, 3) << "red first";
    EXPECT_NEAR(left[2], 0, 3);
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(right[c], 8 * i + 20, 3);
  }
  EXPECT_FALSE(source->next(milliseconds(0)));
  EXPECT_TRUE(source->ended());
  EXPECT_EQ(source->stats().frames, static_cast<std::uint64_t>(kFrames));
}

TEST_F(VideoFile, WhatItIsNotIsNamed) {
  expect_error<ConfigError>([&] { open_video(file_, {.width = 640, .height = 480}); },
                            {file_, "160 x 120", "640 x 480"});
  expect_error<ConfigError>([&] { open_video(file_, {.frame_rate_hz = 30}); },
                            {"frame_rate_hz", "asked 30", "the file has 25"});
  expect_error<ConfigError>([&] { open_video(file_, {.gain_db = 3}); }, {"gain_db", "leave it out"});
  SourceSettings other;
  other.pixel_format = "BayerRG8";
  expect_error<ConfigError>([&] { open_video(file_, other); }, {"pixel_format"});
  expect_error<FileError>([&] { open_video(temp_.path() / "none.avi", {}); }, {"does not exist"});
  std::ofstream(temp_.path() / "text.avi") << "no video";
  expect_error<FileError>([&] { open_video(temp_.path() / "text.avi", {}); }, {"cannot be read as a video"});
}

TEST_F(VideoFile, ThatBreaksOffIsNoEnd) {
  const std::string whole = read_file(file_);
  const std::size_t end_of_frames = whole.rfind("idx1");  // the index of an AVI file, behind its frames
  ASSERT_NE(end_of_frames, std::string::npos);
  const std::size_t first = whole.find("movi");
  std::ofstream(file_, std::ios::trunc | std::ios::binary) << whole.substr(0, first + (end_of_frames - first) / 2);
  std::uint64_t frames = 0;
  expect_error<FileError>(
      [&] {
        const auto source = open_video(file_, {});
        while (!source->ended()) frames += source->next(milliseconds(0)).has_value();
      },
      {file_, "ends too early", "24 frames"});
  EXPECT_NEAR(static_cast<double>(frames), kFrames / 2.0, 3);
}

TEST(VideoDevice, ThatIsNoneIsNamed) {
  expect_error<DeviceError>([] { open_video("/dev/video-of-nobody", {}); },
                            {"/dev/video-of-nobody", "plug the camera in"});
  expect_error<DeviceError>([] { open_video("/dev/null", {}); }, {"/dev/null", "is no V4L2 camera"});
}

/// The controls of a device: it rounds to its step and clamps, as drivers do.
struct ControlledDevice {
  struct Control {
    int value = 0, low = 0, high = 1, step = 1;
    bool stuck = false;
  };
  std::map<std::uint32_t, Control> controls;

  DeviceCall call() {
    return [this](unsigned long request, void* argument) {
      const std::uint32_t id = request == VIDIOC_QUERYCTRL ? static_cast<v4l2_queryctrl*>(argument)->id
                                                           : static_cast<v4l2_control*>(argument)->id;
      const auto found = controls.find(id);
      if (found == controls.end()) return errno = EINVAL, -1;
      Control& control = found->second;
      if (request == VIDIOC_QUERYCTRL) return 0;
      int& value = static_cast<v4l2_control*>(argument)->value;
      if (request == VIDIOC_G_CTRL) return value = control.value, 0;
      if (!control.stuck)
        control.value =
            std::clamp((value - control.low) / control.step * control.step + control.low, control.low, control.high);
      return 0;
    };
  }
};

ControlledDevice web_camera() {
  return {{{V4L2_CID_EXPOSURE_AUTO, {V4L2_EXPOSURE_APERTURE_PRIORITY, 0, 3}},
           {V4L2_CID_EXPOSURE_ABSOLUTE, {156, 1, 5000}},
           {V4L2_CID_AUTO_WHITE_BALANCE, {1}},
           {V4L2_CID_FOCUS_AUTO, {1}}}};
}

std::vector<std::string> lines(const std::vector<LockedFeature>& features) {
  std::vector<std::string> all;
  for (const LockedFeature& f : features) all.push_back(f.feature + "=" + f.got + (f.holds ? "" : " not held"));
  return all;
}

TEST(VideoControls, WhatChangesByItselfIsSwitchedOffAndTheExposureIsSet) {
  ControlledDevice device = web_camera();
  const VideoLocks locks = lock_video_device(device.call(), {.exposure_us = 4000});
  EXPECT_THAT(lines(locks.features),
              ::testing::ElementsAre("auto_exposure=1", "white_balance_automatic=0", "focus_automatic_continuous=0",
                                     "exposure_time_absolute=4000"));
  EXPECT_EQ(device.controls[V4L2_CID_EXPOSURE_ABSOLUTE].value, 40) << "units of 100 us";
  EXPECT_NEAR(locks.exposure_s, 0.004, 1e-12);
  EXPECT_EQ(lock_failures(locks.features), "");
  ControlledDevice unasked = web_camera();
  EXPECT_NEAR(lock_video_device(unasked.call(), {}).exposure_s, 0.0156, 1e-12) << "as it was found";
}

TEST(VideoControls, WhatDoesNotStayIsNamed) {
  ControlledDevice device = web_camera();
  device.controls[V4L2_CID_AUTO_WHITE_BALANCE].stuck = true;
  const auto failures = [&](const SourceSettings& settings) {
    return lock_failures(lock_video_device(device.call(), settings).features);
  };
  EXPECT_THAT(failures({}), HasSubstr("white_balance_automatic: asked 0, got 1"));
  EXPECT_THAT(failures({.exposure_us = 1e6}), HasSubstr("exposure_time_absolute: asked 1e+06, got 500000"));
  EXPECT_THAT(failures({.gain_db = 3}), HasSubstr("not in dB"));
  SourceSettings settings;
  settings.black_level = 4;
  settings.white_balance = {120, 100, 130};
  EXPECT_THAT(failures(settings), AllOf(HasSubstr("black_level"), HasSubstr("red_balance"), HasSubstr("blue_balance")));
  device.controls[V4L2_CID_RED_BALANCE] = device.controls[V4L2_CID_BLUE_BALANCE] = {0, 0, 255, 1};
  EXPECT_THAT(failures(settings), Not(HasSubstr("_balance:")));
  ControlledDevice plain;
  EXPECT_EQ(lock_failures(lock_video_device(plain.call(), {}).features), "");
  EXPECT_THAT(lock_failures(lock_video_device(plain.call(), {.exposure_us = 4000}).features),
              HasSubstr("exposure_time_absolute: asked 4000 us, got this device has none"));
}

/// What a test does with the device behind a feed.
struct Bench {
  std::atomic<bool> plugged = true, hangs = false;
  std::atomic<int> opened = 0;
};

/// A frame every few milliseconds while it is plugged in.
class BenchDevice : public DeviceConnection {
 public:
  explicit BenchDevice(std::shared_ptr<Bench> bench) : bench_(std::move(bench)) {
    if (!bench_->plugged) throw DeviceError("it is not there");
    ++bench_->opened;
  }
  std::optional<Frame> read() override {
    while (bench_->hangs) std::this_thread::sleep_for(milliseconds(1));
    std::this_thread::sleep_for(milliseconds(5));
    if (!bench_->plugged) return std::nullopt;
    return Frame{};
  }
  double frame_rate_hz() const override { return 100; }

 private:
  std::shared_ptr<Bench> bench_;
};

class Feed : public ::testing::Test {
 protected:
  std::unique_ptr<DeviceFeed> feed() const {
    return std::make_unique<DeviceFeed>([bench = bench_] { return std::make_unique<BenchDevice>(bench); });
  }
  static bool eventually(const std::function<bool()>& holds) {
    const auto end = Clock::now() + std::chrono::seconds(10 * testing::kPatienceFactor);
    while (!holds())
      if (Clock::now() > end) return false;
    return true;
  }
  const std::shared_ptr<Bench> bench_ = std::make_shared<Bench>();
};

/// One whose driver throws what it likes, now and then.
class FaultyDevice : public DeviceConnection {
 public:
  std::optional<Frame> read() override {
    if (++reads_ % 3 == 0) throw std::bad_alloc();
    return Frame{};
  }
  double frame_rate_hz() const override { return 100; }

 private:
  int reads_ = 0;
};

TEST(FaultyFeed, WhateverADriverThrowsTheDeviceIsOpenedAgain) {
  std::atomic<int> opened = 0;
  DeviceFeed feed([&opened]() -> std::unique_ptr<DeviceConnection> {
    if (++opened % 2 == 0) throw std::runtime_error("not now");
    return std::make_unique<FaultyDevice>();
  });
  for (int frames = 0; frames < 8;) frames += feed.next(std::chrono::seconds(10)).has_value();
  EXPECT_GE(feed.stats().reopened, 3u);
}

TEST_F(Feed, ADeviceThatIsUnpluggedIsOpenedAgain) {
  const auto source = feed();
  EXPECT_EQ(source->state(), SourceState::kStarting);
  ASSERT_TRUE(eventually([&] { return source->next(milliseconds(20)).has_value(); }));
  EXPECT_EQ(source->state(), SourceState::kLive);
  bench_->plugged = false;
  ASSERT_TRUE(eventually([&] { return source->next(milliseconds(5)), source->state() == SourceState::kStale; }));
  ASSERT_TRUE(eventually([&] { return source->trouble() == "it is not there"; }));
  EXPECT_EQ(source->stats().reopened, 0u);
  bench_->plugged = true;
  ASSERT_TRUE(eventually([&] { return source->next(milliseconds(20)).has_value(); }));
  EXPECT_EQ(source->stats().reopened, 1u);
  EXPECT_EQ(source->trouble(), "");
  EXPECT_EQ(bench_->opened, 2);
}

TEST_F(Feed, ADeviceThatHangsKeepsNobodyWaiting) {
  bench_->hangs = true;
  auto source = feed();
  EXPECT_FALSE(source->next(milliseconds(10)));
  ASSERT_TRUE(eventually([&] { return source->next(milliseconds(5)), source->state() == SourceState::kStale; }));
  source.reset();  // returns although the device does not
  EXPECT_EQ(bench_->opened, 1);
  bench_->hangs = false;
}

TEST_F(Feed, WhatNobodyTakesInTimeIsCounted) {
  const auto source = feed();
  ASSERT_TRUE(eventually([&] { return source->next(milliseconds(20)).has_value(); }));
  ASSERT_TRUE(eventually([&] { return source->stats().missed >= 5; }));
  std::uint64_t last = 0;
  for (int i = 0; i < 8; ++i) {
    const auto frame = source->next(milliseconds(20));
    ASSERT_TRUE(frame);
    EXPECT_GT(frame->camera_frame_id, last);
    last = frame->camera_frame_id;
  }
  EXPECT_GE(last + 1, source->stats().frames + 5) << "the gap is in the ids";
}

/// A V4L2 loopback device: what is written to it is what a camera would deliver.
class LoopbackDevice {
 public:
  /// The first that the kernel has; empty where it has none.
  static std::string find() {
    for (int i = 0; i < 64; ++i) {
      const std::string path = "/dev/video" + std::to_string(i);
      const int fd = ::open(path.c_str(), O_RDWR);
      if (fd < 0) continue;
      v4l2_capability capability{};
      const bool is_loopback = ::ioctl(fd, VIDIOC_QUERYCAP, &capability) == 0 &&
                               std::string(reinterpret_cast<const char*>(capability.driver)) == "v4l2 loopback";
      ::close(fd);
      if (is_loopback) return path;
    }
    return {};
  }
  explicit LoopbackDevice(const std::string& path) : fd_(::open(path.c_str(), O_RDWR)) {
    v4l2_format format{};
    format.type = V4L2_BUF_TYPE_VIDEO_OUTPUT;
    format.fmt.pix.width = 320;
    format.fmt.pix.height = 240;
    format.fmt.pix.pixelformat = V4L2_PIX_FMT_YUYV;
    format.fmt.pix.field = V4L2_FIELD_NONE;
    format.fmt.pix.bytesperline = 640;
    format.fmt.pix.sizeimage = 640 * 240;
    EXPECT_EQ(::ioctl(fd_, VIDIOC_S_FMT, &format), 0) << std::strerror(errno);
    writer_ = std::jthread([this](const std::stop_token& stop) {
      std::string grey(640 * 240, '\x80');
      for (std::size_t i = 0; i < grey.size(); i += 2) grey[i] = static_cast<char>(126);
      while (!stop.stop_requested()) {
        if (!silent) [[maybe_unused]]
          const auto written = ::write(fd_, grey.data(), grey.size());
        std::this_thread::sleep_for(milliseconds(20));
      }
    });
  }
  ~LoopbackDevice() {
    writer_.request_stop();
    writer_.join();
    ::close(fd_);
  }
  std::atomic<bool> silent = false;

 private:
  int fd_;
  std::jthread writer_;
};

TEST(VideoDevice, DeliversFallsSilentAndGoesOn) {
  const std::string path = LoopbackDevice::find();
  if (path.empty()) GTEST_SKIP() << "this kernel has no V4L2 loopback device (modprobe v4l2loopback makes one)";
  LoopbackDevice camera(path);
  const auto source = open_video(path, {.width = 320, .height = 240});
  const auto frame_within = [&](std::chrono::seconds patience) -> std::optional<Frame> {
    for (const auto end = Clock::now() + patience; Clock::now() < end;)
      if (auto frame = source->next(milliseconds(50))) return frame;
    return std::nullopt;
  };
  const auto frame = frame_within(std::chrono::seconds(10));
  ASSERT_TRUE(frame);
  EXPECT_EQ(frame->image.width, 320);
  EXPECT_EQ(frame->image.height, 240);
  EXPECT_NEAR(frame->image.bytes[3 * 160], 128, 4);
  camera.silent = true;
  const auto end = Clock::now() + std::chrono::seconds(10);
  while (source->state() != SourceState::kStale && Clock::now() < end) source->next(milliseconds(20));
  EXPECT_EQ(source->state(), SourceState::kStale);
  camera.silent = false;
  EXPECT_TRUE(frame_within(std::chrono::seconds(20)));
}

}  // namespace
}  // namespace sheen
