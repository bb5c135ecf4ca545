// SPDX-License-Identifier: Apache-2.0
// A real GigE Vision endpoint on the loopback network.
#include <arpa/inet.h>
#include <arv.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <fstream>
#include <map>
#include <optional>
#include <random>
#include <thread>

#include "common/base/errors.h"
#include "tracker/camera_server/camera_server.h"
#include "tracker/sources/aravis_devices.h"
#include "tracker/sources/aravis_source.h"

namespace sheen {
namespace {

using std::chrono::milliseconds;
using Clock = std::chrono::steady_clock;

class Gige : public ::testing::Test {
 protected:
  Gige() {
    std::filesystem::create_directories(recording.folder);
    recording.camera = {.width = 320, .height = 240, .fx = 300, .fy = 300, .cx = 160, .cy = 120};
    recording.frame_rate_hz = 50;
    recording.exposure.exposure_s = 0.004;
    std::mt19937 rng(7);
    for (int i = 0; i < 8; ++i) {
      std::string bytes(320 * 240, '\0');
      for (char& byte : bytes) byte = static_cast<char>(rng());
      recording.frames.push_back({.raw_file = recording.folder / (std::to_string(i) + ".raw")});
      std::ofstream(recording.frames.back().raw_file, std::ios::binary) << bytes;
      contents.push_back(bytes);
    }
  }
  ~Gige() override { std::filesystem::remove_all(recording.folder); }

  static std::optional<Frame> next_frame(FrameSource& source, milliseconds patience) {
    const auto end = Clock::now() + patience;
    while (Clock::now() < end)
      if (auto frame = source.next(milliseconds(20))) return frame;
    return std::nullopt;
  }

  RigRecording recording{
      .folder = std::filesystem::temp_directory_path() /
                ("sheen_gige_" + std::string(::testing::UnitTest::GetInstance()->current_test_info()->name()))};
  std::vector<std::string> contents;
};

TEST_F(Gige, FramesArriveByteExactInOrderAndAreLogged) {
  const CameraServerOptions options{.address = "127.0.0.1"};
  CameraServer server(recording, options);
  AravisSource source(options.address, {.width = 320, .height = 240});
  std::map<std::uint64_t, std::string> received;
  for (int i = 0; i < 12; ++i) {
    const auto frame = next_frame(source, milliseconds(2000));
    ASSERT_TRUE(frame);
    EXPECT_TRUE(frame->complete);
    EXPECT_EQ(frame->image.format, PixelFormat::kBayerRG8);
    EXPECT_EQ(frame->image.width, 320);
    EXPECT_NEAR(frame->exposure.exposure_s, 0.004, 1e-9);
    EXPECT_EQ(frame->exposure.config_epoch, 1u);
    const std::string bytes(frame->image.bytes.begin(), frame->image.bytes.end());
    EXPECT_EQ(bytes, contents[std::min(i, 7)]) << "frame " << i;  // the last is repeated
    received[frame->camera_frame_id] = bytes;
  }
  EXPECT_TRUE(server.exhausted());
  int matched = 0;
  for (const SentFrame& sent : server.take_sent())
    if (const auto it = received.find(sent.camera_frame_id); it != received.end()) {
      EXPECT_EQ(it->second, contents[sent.rig_index]);
      ++matched;
    }
  EXPECT_EQ(matched, 12);
  EXPECT_EQ(source.stats().frames, 12u);
  EXPECT_EQ(source.stats().incomplete, 0u);
  EXPECT_EQ(source.stats().missed, 0u);
  EXPECT_EQ(source.state(), SourceState::kLive);
}

TEST_F(Gige, WhatIsStillRenderedFollowsWhenItIsThere) {
  const CameraServerOptions options{.address = "127.0.0.1"};
  for (std::size_t i = 2; i < recording.frames.size(); ++i) std::filesystem::remove(recording.frames[i].raw_file);
  EXPECT_THROW(CameraServer(recording, options, 0), FileError);
  EXPECT_THROW(CameraServer(recording, options, 3), FileError) << "the third is not there";
  CameraServer server(recording, options, 2);
  AravisSource source(options.address, {.width = 320, .height = 240});
  const auto content = [&] {
    const auto frame = next_frame(source, milliseconds(2000));
    return frame ? std::string(frame->image.bytes.begin(), frame->image.bytes.end()) : "no frame";
  };
  EXPECT_EQ(content(), contents[0]);
  for (int i = 0; i < 5; ++i) EXPECT_EQ(content(), contents[1]) << "the last that is there";
  EXPECT_FALSE(server.exhausted());
  for (std::size_t i = 2; i < contents.size(); ++i)
    std::ofstream(recording.frames[i].raw_file, std::ios::binary) << contents[i];
  server.load_until(contents.size());
  const auto end = Clock::now() + milliseconds(5000);
  std::string last;
  while (last != contents.back() && Clock::now() < end) last = content();
  EXPECT_EQ(last, contents.back());
  EXPECT_TRUE(server.exhausted());
  std::vector<std::size_t> order;
  for (const SentFrame& sent : server.take_sent())
    if (order.empty() || order.back() != sent.rig_index) order.push_back(sent.rig_index);
  EXPECT_EQ(order, (std::vector<std::size_t>{0, 1, 2, 3, 4, 5, 6, 7})) << "each, in order";
}

TEST_F(Gige, AnUnpluggedCameraIsNoticedAndGoesOnWhenItIsBack) {
  const CameraServerOptions options{.address = "127.0.0.1", .loop = true};
  auto server = std::make_unique<CameraServer>(recording, options);
  AravisSource source(options.address, {.width = 320, .height = 240});
  ASSERT_TRUE(next_frame(source, milliseconds(2000)));
  server.reset();
  const auto unplugged = Clock::now();
  while (source.state() != SourceState::kStale && Clock::now() < unplugged + milliseconds(3000))
    source.next(milliseconds(20));
  EXPECT_EQ(source.state(), SourceState::kStale);
  EXPECT_THAT(source.message(), ::testing::HasSubstr("stopped delivering"));
  while (Clock::now() < unplugged + milliseconds(1500)) source.next(milliseconds(20));
  server = std::make_unique<CameraServer>(recording, options);
  const auto back = Clock::now();
  ASSERT_TRUE(next_frame(source, milliseconds(15000)));
  EXPECT_EQ(source.state(), SourceState::kLive);
  // Once; on a machine that is busy the camera may be silent again before its first frame, each time for this long.
  constexpr milliseconds kReopen{700};
  EXPECT_GE(source.stats().reopened, 1u);
  EXPECT_LE(source.stats().reopened, 1u + static_cast<std::uint64_t>((Clock::now() - back) / kReopen));
}

/// A camera that was told by a program that has ended to send to a port which has another's stream now: one grey image
/// of 16 x 16 pixels, in the three packets of the GigE Vision stream protocol.
void send_foreign_image(std::uint16_t port, std::uint16_t id) {
  const auto packet = [&](std::uint32_t type_and_number, std::vector<std::uint32_t> words, std::size_t pixels = 0) {
    words.insert(words.begin(), {id, type_and_number});
    for (std::uint32_t& word : words) word = htonl(word);
    std::string bytes(reinterpret_cast<const char*>(words.data()), 4 * words.size());
    return bytes + std::string(pixels, 'x');
  };
  const sockaddr_in there{.sin_family = AF_INET, .sin_port = htons(port), .sin_addr = {htonl(INADDR_LOOPBACK)}};
  const int socket = ::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  for (const std::string& bytes : {packet(0x01000000, {1, 0, 0, ARV_PIXEL_FORMAT_MONO_8, 16, 16, 0, 0, 0}),
                                   packet(0x03000001, {}, 256), packet(0x02000002, {1, 16})})
    EXPECT_EQ(sendto(socket, bytes.data(), bytes.size(), 0, reinterpret_cast<const sockaddr*>(&there), sizeof there),
              ssize_t(bytes.size()));
  close(socket);
}

TEST_F(Gige, WhatAnotherCameraSendsToItsPortIsNotTakenForItsOwn) {
  const CameraServerOptions options{.address = "127.0.0.1"};
  CameraServer server(recording, options);
  AravisSource source(options.address, {.width = 320, .height = 240});
  auto frame = next_frame(source, milliseconds(2000));
  ASSERT_TRUE(frame);
  const std::unique_ptr<ArvCamera, void (*)(void*)> watched(arv_camera_new("127.0.0.1", nullptr), g_object_unref);
  guint32 port = 0;
  ASSERT_TRUE(watched && arv_device_read_register(arv_camera_get_device(watched.get()), 0x0d00, &port, nullptr));
  for (int i = 0; i < 200 && source.stats().foreign == 0; ++i) {
    send_foreign_image(static_cast<std::uint16_t>(port), static_cast<std::uint16_t>(frame->camera_frame_id + 20));
    frame = next_frame(source, milliseconds(2000));
    ASSERT_TRUE(frame);
    EXPECT_TRUE(!frame->complete || frame->image.width == 320);
  }
  EXPECT_GE(source.stats().foreign, 1u);
}

TEST_F(Gige, AMissingCameraIsAClearError) {
  try {
    AravisSource source("127.0.0.43", {});
    FAIL() << "there is no camera";
  } catch (const DeviceError& error) {
    EXPECT_THAT(error.what(), ::testing::HasSubstr("127.0.0.43 does not answer"));
  }
}

TEST_F(Gige, ACameraOfThisMachineDeliversUnderTheNameThatIsListed) {
  CameraServer server(recording, {.address = "127.0.0.1"});
  const std::vector<CameraDevice> listed = discover_cameras();
  const auto ours = std::ranges::find(listed, std::string("127.0.0.1"), &CameraDevice::address);
  ASSERT_NE(ours, listed.end());
  AravisSource source(ours->id, {});
  EXPECT_TRUE(next_frame(source, milliseconds(2000))) << ours->id;
}

TEST_F(Gige, WhatCannotBeServedIsAClearError) {
  EXPECT_THROW(CameraServer(recording, {.address = "10.1.2.3"}), ConfigError);
  std::filesystem::resize_file(recording.frames[3].raw_file, 100);
  EXPECT_THROW(CameraServer(recording, {.address = "127.0.0.1"}), FileError);
  recording.frames.clear();
  EXPECT_THROW(CameraServer(recording, {.address = "127.0.0.1"}), FileError);
}

TEST_F(Gige, AnAddressHasOneCamera) {
  std::optional<CameraServer> first(std::in_place, recording, CameraServerOptions{.address = "127.0.0.1"});
  EXPECT_THROW(CameraServer(recording, {.address = "127.0.0.1"}), DeviceError);
  first.reset();
  EXPECT_NO_THROW(CameraServer(recording, {.address = "127.0.0.1"}));
}

TEST_F(Gige, AnotherSizeThanTheConfigurationsIsAClearError) {
  const CameraServerOptions options{.address = "127.0.0.1"};
  CameraServer server(recording, options);
  EXPECT_THROW(AravisSource(options.address, {.width = 640, .height = 480}), DeviceError);
}

}  // namespace
}  // namespace sheen
