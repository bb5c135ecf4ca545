// SPDX-License-Identifier: Apache-2.0
// Messages of protocol version 1 as they were when it was fixed. They must decode for as long as version 1 is spoken,
// and, but for zstd's output, which may differ from release to release, be produced to the byte.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>

#include "common/link/wire.h"
#include "common/link/wire_messages.h"
#include "tests/support/camera_responses.h"
#include "tests/support/expect_same_bits.h"
#include "tests/support/sample_capture.h"

namespace sheen {
namespace {

Bytes from_hex(const std::string& hex) {
  Bytes bytes;
  for (std::size_t i = 0; i + 1 < hex.size(); i += 2)
    bytes.push_back(static_cast<std::uint8_t>(std::stoi(hex.substr(i, 2), nullptr, 16)));
  return bytes;
}

std::string to_hex(std::span<const std::uint8_t> bytes) {
  std::string hex;
  for (const std::uint8_t b : bytes) {
    hex += "0123456789abcdef"[b >> 4];
    hex += "0123456789abcdef"[b & 15];
  }
  return hex;
}

Capture golden_capture() {
  Capture c;
  c.source_session = "golden";
  c.sequence = 300;
  c.camera_frame_id = 65535;
  c.name = "view 7";
  c.times = {1, -2, 3'000'000'000, 4};
  c.camera = {.width = 4, .height = 2, .fx = 5, .fy = 6, .cx = 1.5, .cy = 0.5};
  c.camera.distortion = {0.5, -0.25, 0.125, 0, 1};
  c.image = {PixelFormat::kBayerGR8, Transfer::kLinear, 4, 2, 5, {1, 2, 3, 4, 99, 5, 6, 7, 8, 98}};
  c.mask = ImageU8(4, 2, 1, 255);
  c.mask.at(1, 1) = 0;
  c.exposure = {0.0078125, 3, {2, 1, 1.5f}, 0.0625f, true, 9};
  c.pose.status = PoseStatus::kTracked;
  c.pose.camera_from_object = {Eigen::Quaterniond(0.5, -0.5, 0.5, 0.5), {0.25, 0, -1}};
  c.pose.covariance.diagonal() << 1, 2, 3, 4, 5, 6;
  c.pose.covariance(0, 1) = c.pose.covariance(1, 0) = 0.5;
  c.pose.reprojection_rms_px = 0.125;
  c.pose.blur_px = 0.5;
  c.pose.tags_used = 1;
  c.tags = {{.id = 12, .residual_px = 0.25, .used = true}};
  c.tags[0].corners = {Eigen::Vector2d(0, 1), Eigen::Vector2d(2, 3), Eigen::Vector2d(4, 5), Eigen::Vector2d(6, 7)};
  c.light = {LightKind::kDirectional, {0, 0, 1}, {1, 0.5f, 0.25f}};
  c.verdict = FrameVerdict::kKeyframe;
  c.purpose = Purpose::kTraining;
  c.calibration_hash = "cal";
  c.stage_hash = "stage";
  return c;
}

const char* const kEnvelopeHex = "5348454e01000400";
const char* const kRawHeaderHex =
    "0a06676f6c64656e10ac0218ffff0322067669657720372a2409010000000000000011feffffffffffffff19005ed0b20000"
    "000021040000000000000032540804100219000000000000144021000000000000184029000000000000f83f310000000000"
    "00e03f38014228000000000000e03f000000000000d0bf000000000000c03f0000000000000000000000000000f03f3a0a08"
    "0310011804200228054204080410024a09080110121dce8bb69f522909000000000000803f1100000000000008401a0c0000"
    "00400000803f0000c03f250000803d280130095af50208011220000000000000e0bf000000000000e03f000000000000e03f"
    "000000000000e03f1a18000000000000d03f0000000000000000000000000000f0bf22a002000000000000f03f0000000000"
    "00e03f0000000000000000000000000000000000000000000000000000000000000000000000000000e03f00000000000000"
    "4000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000"
    "0000000000084000000000000000000000000000000000000000000000000000000000000000000000000000000000000000"
    "0000000000000000000000104000000000000000000000000000000000000000000000000000000000000000000000000000"
    "0000000000000000000000000000000000144000000000000000000000000000000000000000000000000000000000000000"
    "0000000000000000000000000000000000000000000000184029000000000000c03f31000000000000e03f3801624f080c12"
    "400000000000000000000000000000f03f000000000000004000000000000008400000000000001040000000000000144000"
    "000000000018400000000000001c4019000000000000d03f20016a2a08021218000000000000000000000000000000000000"
    "00000000f03f1a0c0000803f0000003f0000803e7001780182010363616c8a01057374616765";
const char* const kRawBlobHex = "01020304630506070862ffffffffff00ffff";
const char* const kZstdHeaderHex =
    "0a06676f6c64656e10ac0218ffff0322067669657720372a2409010000000000000011feffffffffffffff19005ed0b20000"
    "000021040000000000000032540804100219000000000000144021000000000000184029000000000000f83f310000000000"
    "00e03f38014228000000000000e03f000000000000d0bf000000000000c03f0000000000000000000000000000f03f3a0a08"
    "0310011804200228054204080410024a090802101b1dcaafb6fa522909000000000000803f1100000000000008401a0c0000"
    "00400000803f0000c03f250000803d280130095af50208011220000000000000e0bf000000000000e03f000000000000e03f"
    "000000000000e03f1a18000000000000d03f0000000000000000000000000000f0bf22a002000000000000f03f0000000000"
    "00e03f0000000000000000000000000000000000000000000000000000000000000000000000000000e03f00000000000000"
    "4000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000000"
    "0000000000084000000000000000000000000000000000000000000000000000000000000000000000000000000000000000"
    "0000000000000000000000104000000000000000000000000000000000000000000000000000000000000000000000000000"
    "0000000000000000000000000000000000144000000000000000000000000000000000000000000000000000000000000000"
    "0000000000000000000000000000000000000000000000184029000000000000c03f31000000000000e03f3801624f080c12"
    "400000000000000000000000000000f03f000000000000004000000000000008400000000000001040000000000000144000"
    "000000000018400000000000001c4019000000000000d03f20016a2a08021218000000000000000000000000000000000000"
    "00000000f03f1a0c0000803f0000003f0000803e7001780182010363616c8a01057374616765";
const char* const kZstdBlobHex = "28b52ffd201291000001020202630506020262ff000000ff01ff00";

TEST(WireGolden, VersionOneIsWrittenToTheByte) {
  const EncodedCapture m = encode_capture(golden_capture(), MessageType::kKeep, Codec::kRaw);
  EXPECT_EQ(to_hex(m.envelope), kEnvelopeHex);
  EXPECT_EQ(to_hex(m.header), kRawHeaderHex);
  EXPECT_EQ(to_hex(m.blob), kRawBlobHex);
}

TEST(WireGolden, VersionOneIsRead) {
  testing::expect_same_bits(golden_capture(),
                            decode_capture(from_hex(kEnvelopeHex), from_hex(kRawHeaderHex), from_hex(kRawBlobHex)));
  testing::expect_same_bits(golden_capture(),
                            decode_capture(from_hex(kEnvelopeHex), from_hex(kZstdHeaderHex), from_hex(kZstdBlobHex)));
}

/// Little-endian bytes of numbers.
template <typename Number>
std::string hex_of(const std::vector<Number>& numbers) {
  std::string hex;
  for (const Number number : numbers) {
    std::uint8_t bytes[sizeof number];
    std::memcpy(bytes, &number, sizeof number);
    hex += to_hex(bytes);
  }
  return hex;
}

// What came later stands at the end and changes nothing before it.
TEST(WireGolden, APhotometryFollowsWhatVersionOneHad) {
  Capture capture = golden_capture();
  capture.photometry = Photometry{linear_response(0.125), {1.5, 0.25, {-0.5, 0.25, -0.125}}, {2, 1, 1.5f}, 0.75f};
  std::vector<float> light;
  for (int value = 0; value < 256; ++value)
    light.push_back(static_cast<float>(std::max(0.0, (value / 255.0 - 0.125) / 0.875)));
  const std::string photometry = "0a8008" + hex_of(light) +                         // field 1, 1024 bytes
                                 "1210" + hex_of(std::vector<double>{1.5, 0.25}) +  //
                                 "1a18" + hex_of(std::vector<double>{-0.5, 0.25, -0.125}) + "220c" +
                                 hex_of(std::vector<float>{2, 1, 1.5f}) +  //
                                 "2d" + hex_of(std::vector<float>{0.75f});
  ASSERT_EQ(photometry.size() / 2, 1090u);
  const std::string header = kRawHeaderHex + std::string("9201c208") + photometry;  // field 18, 1090 bytes
  EXPECT_EQ(to_hex(encode_capture(capture, MessageType::kKeep, Codec::kRaw).header), header);
  testing::expect_same_bits(capture, decode_capture(from_hex(kEnvelopeHex), from_hex(header), from_hex(kRawBlobHex)));
}

TEST(WireGolden, LinkMessagesOfVersionOneAreWrittenToTheByte) {
  EXPECT_EQ(to_hex(encode(Hello{"reconstructor", 2, {{"a", {3, 5}}}, 1})),
            "0a0d7265636f6e7374727563746f7210021a070a016110031805210100000000000000");
  EXPECT_EQ(to_hex(encode(Welcome{"a", 9, 1, 2})), "0a01611009190100000000000000210200000000000000");
  EXPECT_EQ(to_hex(encode(Credit{4})), "0804");
  EXPECT_EQ(to_hex(encode(Ack{"a", 6, true})), "0a016110061801");
  EXPECT_EQ(to_hex(encode(Refuse{"no"})), "0a026e6f");
  EXPECT_EQ(to_hex(encode(End{"a", 12})), "0a0161100c");
  EXPECT_EQ(to_hex(encode(End{"a", 12, "b"})), "0a0161100c1a0162");
  const Status status{"tracker", "s", 5, 7, SourceState::kLive, "ok", {{"x", 0.5}}, {9}};
  EXPECT_EQ(to_hex(encode_status(status)),
            "5348454e010008000a07747261636b65721201731805210700000000000000280232026f6b3a0c0a017811000000000000e0"
            "3f420109");
}

}  // namespace
}  // namespace sheen
