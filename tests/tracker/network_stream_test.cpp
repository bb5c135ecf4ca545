// SPDX-License-Identifier: Apache-2.0
// Live streams of a server on this machine, as camera apps of telephones send them: what they deliver, what becomes of
// them when the network or the app fails, and what a person is told.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "common/base/errors.h"
#include "common/image/image_io.h"
#include "tests/support/expect_error.h"
#include "tests/support/mjpeg_server.h"
#include "tests/support/patience.h"
#include "tests/support/process.h"
#include "tests/support/rtsp_server.h"
#include "tracker/sources/stream_address.h"
#include "tracker/sources/video_source.h"

namespace sheen {
namespace {

using std::chrono::milliseconds;
using ::testing::HasSubstr;
using testing::MjpegServer;
using ::testing::Not;
using Clock = std::chrono::steady_clock;

constexpr int kWidth = 160, kHeight = 120;

/// Grey of which the level says the picture's number, with a red left half: JPEG keeps flat colours.
std::string numbered(std::uint64_t number, int width = kWidth, int height = kHeight) {
  ImageU8 image(width, height, 3);
  const auto level = static_cast<std::uint8_t>(20 + 2 * (number % 100));
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      image.pixel(x, y)[0] = level;
      image.pixel(x, y)[1] = image.pixel(x, y)[2] = x < width / 2 ? std::uint8_t(0) : level;
    }
  const std::vector<std::uint8_t> bytes = encode_jpeg(image, 95);
  return {bytes.begin(), bytes.end()};
}

MjpegServer::Picture numbers() {
  return [](std::uint64_t i) { return numbered(i); };
}

/// The number of the picture that a frame shows, modulo 100.
int number_of(const Frame& frame) {
  const std::size_t middle = frame.image.stride * (frame.image.height / 2) + 3 * (frame.image.width * 3 / 4);
  return (frame.image.bytes[middle + 1] - 20 + 1) / 2;
}

bool eventually(const std::function<bool()>& holds) {
  const auto end = Clock::now() + std::chrono::seconds(20 * testing::kPatienceFactor);
  while (!holds())
    if (Clock::now() > end) return false;
  return true;
}

std::optional<Frame> next_of(FrameSource& source) {
  std::optional<Frame> frame;
  eventually([&] { return (frame = source.next(milliseconds(20))).has_value(); });
  return frame;
}

TEST(LiveStream, ItsPicturesAreDelivered) {
  for (const bool lengths : {true, false}) {
    MjpegServer server(numbers(), {.states_lengths = lengths});
    const auto source = open_video(server.address(), {.width = kWidth, .height = kHeight});
    EXPECT_TRUE(source->live());
    EXPECT_TRUE(source->compressed());
    std::optional<std::uint64_t> last;
    for (int i = 0; i < 10; ++i) {
      const auto frame = next_of(*source);
      ASSERT_TRUE(frame) << i;
      EXPECT_TRUE(frame->complete);
      EXPECT_EQ(frame->image.width, kWidth);
      EXPECT_EQ(frame->image.height, kHeight);
      EXPECT_EQ(frame->image.transfer, Transfer::kSrgb);
      EXPECT_NEAR(frame->image.bytes[1], 0, 6) << "red on the left";
      EXPECT_EQ(frame->exposure.exposure_s, 0) << "nobody knows it";
      EXPECT_FALSE(frame->exposure.locked);
      EXPECT_GT(frame->times.device_ns, 0);
      if (last) EXPECT_GT(frame->camera_frame_id, *last);
      last = frame->camera_frame_id;
    }
    EXPECT_THAT(source->remarks(), AllOf(HasSubstr("exposure is not known"), HasSubstr("Lock exposure")));
    EXPECT_THAT(source->message(), HasSubstr("delivers"));
  }
}

TEST(LiveStream, TheNewestWinsAndWhatWasOvertakenIsCounted) {
  MjpegServer server(numbers(), {.between = milliseconds(5)});
  const auto source = open_video(server.address(), {});
  const auto first = next_of(*source);
  ASSERT_TRUE(first);
  ASSERT_TRUE(eventually([&] { return source->stats().missed >= 40; })) << "nobody takes them";
  const auto next = next_of(*source);
  ASSERT_TRUE(next);
  EXPECT_GE(next->camera_frame_id - first->camera_frame_id, 40u) << "the gap is in the ids";
  server.silent = true;
  std::optional<Frame> last = next;
  EXPECT_TRUE(eventually([&] {
    if (auto frame = source->next(milliseconds(20))) last = std::move(frame);
    return number_of(*last) == static_cast<int>((server.sent() - 1) % 100);
  })) << "the newest has not come";
}

TEST(LiveStream, ThatEndsIsConnectedToAgain) {
  MjpegServer server(numbers());
  const auto source = open_video(server.address(), {});
  ASSERT_TRUE(next_of(*source));
  server.hangs_up = true;
  ASSERT_TRUE(eventually([&] { return source->next(milliseconds(20)), source->stats().reopened == 1; }));
  ASSERT_TRUE(next_of(*source));
  EXPECT_EQ(server.callers(), 2u);
  server.refuses = true;
  ASSERT_TRUE(eventually([&] { return source->next(milliseconds(20)), source->state() == SourceState::kStale; }));
  EXPECT_THAT(source->message(), AllOf(HasSubstr(server.address()), Not(HasSubstr("delivers"))));
  server.refuses = false;
  ASSERT_TRUE(eventually([&] { return source->next(milliseconds(20)), source->stats().reopened == 2; }));
  ASSERT_TRUE(next_of(*source));
}

TEST(LiveStream, ThatFallsSilentKeepsNobodyWaiting) {
  MjpegServer server(numbers());
  auto source = open_video(server.address(), {});
  ASSERT_TRUE(next_of(*source));
  server.silent = true;
  ASSERT_TRUE(eventually([&] { return source->next(milliseconds(5)), source->state() == SourceState::kStale; }));
  source.reset();  // returns although nothing comes
}

TEST(LiveStream, ABrokenPictureIsAFrameThatIsNotComplete) {
  MjpegServer server([](std::uint64_t i) {
    const std::string whole = numbered(i);
    return i % 4 == 3 ? whole.substr(0, whole.size() / 2) : whole;
  });
  const auto source = open_video(server.address(), {});
  int broken = 0, whole = 0;
  for (int i = 0; i < 16; ++i) {
    const auto frame = next_of(*source);
    ASSERT_TRUE(frame);
    ++(frame->complete ? whole : broken);
    if (frame->complete) EXPECT_NE(number_of(*frame) % 4, 3);
  }
  EXPECT_GE(broken, 2);
  EXPECT_EQ(source->stats().incomplete, static_cast<std::uint64_t>(broken));
  EXPECT_GE(whole, 6);
  EXPECT_EQ(source->stats().reopened, 0u);
}

TEST(LiveStream, OfAnotherSizeThanTheCameraIsRefused) {
  MjpegServer server(numbers());
  expect_error<ConfigError>([&] { open_video(server.address(), {.width = 640, .height = 480}); },
                            {"160 x 120", "640 x 480", "calibration"});
}

TEST(LiveStream, ThatIsTurnedIsNamedUntilItIsTurnedBack) {
  std::atomic<bool> turned = false;
  MjpegServer server([&](std::uint64_t i) { return turned ? numbered(i, kHeight, kWidth) : numbered(i); });
  const auto source = open_video(server.address(), {});
  ASSERT_TRUE(next_of(*source));
  turned = true;
  std::string said;
  ASSERT_TRUE(eventually([&] {
    if (const auto frame = source->next(milliseconds(5))) EXPECT_EQ(frame->image.width, kWidth);
    said = source->message();
    return said.find("are expected") != std::string::npos;
  }));
  EXPECT_THAT(said, AllOf(HasSubstr("120 x 160"), HasSubstr("160 x 120"), HasSubstr("hold the phone as it was")));
  turned = false;
  ASSERT_TRUE(next_of(*source));
}

TEST(LiveStream, WhatIsWrongWithItIsNamedWithoutItsPassword) {
  const auto refusal = [](const std::string& address, const SourceSettings& settings = {}) {
    try {
      open_video(address, settings);
    } catch (const Error& error) {
      EXPECT_THAT(error.what(), Not(HasSubstr("hunter2")));
      return std::string(error.what());
    }
    return std::string("it opened");
  };
  const auto answered = [&](const MjpegServer::Options& options, const std::string& user = {}) {
    MjpegServer server(numbers(), options);
    return refusal(server.address(user));
  };
  const std::string nobody = "127.0.0.1:" + std::to_string(testing::free_port());
  EXPECT_THAT(refusal("http://me:hunter2@" + nobody + "/video"),
              AllOf(HasSubstr("http://me:***@" + nobody + "/video"), HasSubstr("refuses the connection")));
  EXPECT_THAT(refusal("rtsp://me:hunter2@" + nobody + "/live"), HasSubstr("refuses the connection"));
  EXPECT_THAT(answered({.user_and_password = "me:right"}, "me:hunter2"), HasSubstr("401"));
  EXPECT_THAT(answered({.user_and_password = "me:right"}), HasSubstr("http://NAME:PASSWORD@HOST"));
  EXPECT_THAT(answered({.status = "404 Not Found"}), AllOf(HasSubstr("404"), HasSubstr("/video")));
  EXPECT_THAT(answered({.status = "503 Busy"}), HasSubstr("5xx"));
  EXPECT_THAT(answered({.content_type = "text/html", .body = "<html>choose a camera</html>"}),
              HasSubstr("not with a stream of pictures"));
  EXPECT_THAT(answered({.content_type = "application/octet-stream", .body = std::string(5000, 'x')}),
              HasSubstr("not with a stream of pictures"));
  EXPECT_THAT(answered({.content_type = "image/jpeg", .body = numbered(1)}), HasSubstr("a single picture"));
  EXPECT_THAT(answered({.body = "--picture\r\nContent-Type: text/plain\r\n\r\nno\r\n--picture\r\n"}),
              HasSubstr("not with a stream of pictures"));
  MjpegServer server(numbers());
  EXPECT_THAT(refusal(server.address(), {.frame_rate_hz = 30}), HasSubstr("source.frame_rate_hz cannot be set"));
  EXPECT_THAT(refusal(server.address(), {.exposure_us = 1000}), HasSubstr("source.exposure_us cannot be set"));
  EXPECT_THAT(refusal("ftp://me:hunter2@host/video"), HasSubstr("http://, https://, rtsp:// or rtsps://"));
}

TEST(LiveStream, WithANameAndAPasswordIsOpened) {
  MjpegServer server(numbers(), {.user_and_password = "me:hunter2"});
  const auto source = open_video(server.address("me:hunter2"), {});
  ASSERT_TRUE(next_of(*source));
  for (const std::string& said : {source->message(), source->remarks()})
    EXPECT_THAT(said, AllOf(HasSubstr("me:***@"), Not(HasSubstr("hunter2"))));
}

/// Of a picture of the RTSP server, modulo 16.
int number_over_rtsp(const Frame& frame) {
  const int code = frame.image.bytes[frame.image.stride * (frame.image.height / 2) + 3 * (frame.image.width / 2)];
  const double luma = 16 + code * 219 / 255.0;  // video of limited range
  return int(std::lround((luma - 40) / 10));
}

TEST(LiveStream, OverRtspIsDeliveredAndConnectedToAgain) {
  testing::RtspServer camera(320, 240, milliseconds(40));
  const auto source = open_video(camera.address(), {.width = 320, .height = 240});
  for (int i = 0; i < 20; ++i) {
    const auto frame = next_of(*source);
    ASSERT_TRUE(frame) << i;
    EXPECT_TRUE(frame->complete);
    EXPECT_EQ(frame->image.width, 320);
    EXPECT_GE(number_over_rtsp(*frame), 0);
    EXPECT_LT(number_over_rtsp(*frame), 16);
  }
  camera.hangs_up = true;
  ASSERT_TRUE(eventually([&] { return source->next(milliseconds(20)), source->stats().reopened == 1; }));
  ASSERT_TRUE(next_of(*source));
}

TEST(StreamAddress, ItsPasswordIsNotShown) {
  EXPECT_EQ(without_password("video:http://phone:8080/video"), "video:http://phone:8080/video");
  EXPECT_EQ(without_password("rtsp://me:a@b@phone:554/live"), "rtsp://me:***@phone:554/live");
  EXPECT_EQ(without_password("http://me:a/b@phone:8080/video"), "http://me:***@phone:8080/video");
  EXPECT_EQ(without_password("http://phone:8080/by@name"), "http://phone:8080/by@name");
  EXPECT_EQ(without_password("http://me@phone/video"), "http://me@phone/video");
  EXPECT_EQ(without_password("http://c/v.cgi?user=me&pwd=x&loginPass=y&size=2"),
            "http://c/v.cgi?user=me&pwd=***&loginPass=***&size=2");
  EXPECT_EQ(without_password("/data/no:address@all"), "/data/no:address@all");
}

TEST(StreamAddress, WhatIsNoneIsNamed) {
  EXPECT_EQ(address_error("http://phone:8080/video"), "");
  EXPECT_EQ(address_error("RTSP://me:x@phone/live"), "");
  EXPECT_THAT(address_error("http://"), HasSubstr("names no host"));
  EXPECT_THAT(address_error("http://me:x@:8080/"), HasSubstr("names no host"));
  EXPECT_THAT(address_error("http://phone/my video"), HasSubstr("%20"));
  EXPECT_THAT(address_error("file:///etc/passwd"), HasSubstr("begins with"));
  expect_error<ConfigError>([] { parse_source_uri("http://me:hunter2@phone/video"); },
                            {"write video:http://me:***@phone/video"});
}

}  // namespace
}  // namespace sheen
