// SPDX-License-Identifier: Apache-2.0
#include "support/sample_capture.h"

#include <gtest/gtest.h>

#include <bit>
#include <random>

namespace sheen::testing {
namespace {

void expect_same_bits(double a, double b, const char* field) {
  EXPECT_EQ(std::bit_cast<std::uint64_t>(a), std::bit_cast<std::uint64_t>(b)) << field;
}
void expect_same_bits(float a, float b, const char* field) {
  EXPECT_EQ(std::bit_cast<std::uint32_t>(a), std::bit_cast<std::uint32_t>(b)) << field;
}
template <typename Range>
void expect_same_range(const Range& a, const Range& b, const char* field) {
  for (long i = 0; i < static_cast<long>(a.size()); ++i) expect_same_bits(a.data()[i], b.data()[i], field);
}

}  // namespace

Capture sample_capture(PixelFormat format, int width, int height, std::size_t padding, bool with_mask, unsigned seed) {
  std::mt19937 random(seed);
  Capture c;
  c.source_session = "rig-7f3a";
  c.sequence = 41;
  c.camera_frame_id = 65'540;
  c.name = "Büste 003.png";
  c.times = {-5, 123'456'789'012'345, 123'456'789'999'999, 7};
  c.camera = {.width = width, .height = height, .fx = 1200.25, .fy = 1199.75, .cx = width / 2.0, .cy = -0.0};
  c.camera.distortion = {-0.1, 0.02, 1e-4, -1e-4, -0.003};
  c.image = {.format = format, .transfer = Transfer::kSrgb, .width = width, .height = height};
  c.image.stride = width * bytes_per_pixel(format) + padding;
  c.image.bytes.resize(c.image.stride * height);
  for (std::size_t i = 0; i < c.image.bytes.size(); ++i)
    c.image.bytes[i] = static_cast<std::uint8_t>(i % 200 + random() % 16);
  if (with_mask) {
    c.mask = ImageU8(width, height, 1);
    for (std::size_t i = 0; i < c.mask.size(); ++i) c.mask.data()[i] = random() % 2 ? 255 : 0;
  }
  c.exposure = {.exposure_s = 0.008,
                .gain_db = 3.5,
                .white_balance = {1.9f, 1, 1.4f},
                .black_level = 0.015f,
                .locked = true,
                .config_epoch = 3};
  c.pose.status = PoseStatus::kTracked;
  c.pose.camera_from_object.rotation = Eigen::Quaterniond(0.3, -0.4, 0.5, 0.7).normalized();
  c.pose.camera_from_object.translation = {0.1, -0.0, 0.6543210987654321};
  Eigen::Matrix<double, 6, 6> factor;
  for (double& value : factor.reshaped()) value = 1e-4 * (int(random() % 2001) - 1000) / 1000;
  c.pose.covariance = factor * factor.transpose();
  c.pose.reprojection_rms_px = 0.035;
  c.pose.blur_px = 0.7;
  c.pose.tags_used = 1;
  c.tags.resize(2);
  for (int t = 0; t < 2; ++t) {
    c.tags[t] = {.id = 17 * t, .residual_px = 0.01 + t, .used = t == 0};
    for (int k = 0; k < 4; ++k) c.tags[t].corners[k] = {10.125 * k + t, -3.0 * k};
  }
  c.light = {.kind = LightKind::kPoint, .position = {0.5, -0.25, 1e-300}, .rgb = {0.5f, 1e-40f, 2}};
  c.verdict = FrameVerdict::kKeyframe;
  c.purpose = Purpose::kHeldOut;
  c.calibration_hash = "c0ffee";
  c.stage_hash = "5ta9e";
  return c;
}

Capture sample_capture(const std::string& source_session, std::uint64_t sequence) {
  Capture c = sample_capture(PixelFormat::kBayerRG8, 24, 16, 0, false, static_cast<unsigned>(sequence));
  c.source_session = source_session;
  c.sequence = sequence;
  return c;
}

void expect_same_bits(const Capture& a, const Capture& b) {
  EXPECT_EQ(a.source_session, b.source_session);
  EXPECT_EQ(a.sequence, b.sequence);
  EXPECT_EQ(a.camera_frame_id, b.camera_frame_id);
  EXPECT_EQ(a.name, b.name);
  EXPECT_EQ(a.times.device_ns, b.times.device_ns);
  EXPECT_EQ(a.times.grabbed_ns, b.times.grabbed_ns);
  EXPECT_EQ(a.times.sent_ns, b.times.sent_ns);
  EXPECT_EQ(a.camera.width, b.camera.width);
  EXPECT_EQ(a.camera.height, b.camera.height);
  EXPECT_EQ(a.camera.lens, b.camera.lens);
  expect_same_bits(a.camera.fx, b.camera.fx, "fx");
  expect_same_bits(a.camera.fy, b.camera.fy, "fy");
  expect_same_bits(a.camera.cx, b.camera.cx, "cx");
  expect_same_bits(a.camera.cy, b.camera.cy, "cy");
  expect_same_range(a.camera.distortion, b.camera.distortion, "distortion");
  EXPECT_EQ(a.image, b.image);
  EXPECT_EQ(a.mask, b.mask);
  expect_same_bits(a.exposure.exposure_s, b.exposure.exposure_s, "exposure_s");
  expect_same_bits(a.exposure.gain_db, b.exposure.gain_db, "gain_db");
  expect_same_range(a.exposure.white_balance, b.exposure.white_balance, "white_balance");
  expect_same_bits(a.exposure.black_level, b.exposure.black_level, "black_level");
  EXPECT_EQ(a.exposure.locked, b.exposure.locked);
  EXPECT_EQ(a.exposure.config_epoch, b.exposure.config_epoch);
  EXPECT_EQ(a.pose.status, b.pose.status);
  expect_same_range(a.pose.camera_from_object.rotation.coeffs(), b.pose.camera_from_object.rotation.coeffs(), "q");
  expect_same_range(a.pose.camera_from_object.translation, b.pose.camera_from_object.translation, "t");
  expect_same_range(a.pose.covariance, b.pose.covariance, "covariance");
  expect_same_bits(a.pose.reprojection_rms_px, b.pose.reprojection_rms_px, "reprojection_rms_px");
  expect_same_bits(a.pose.blur_px, b.pose.blur_px, "blur_px");
  EXPECT_EQ(a.pose.tags_used, b.pose.tags_used);
  ASSERT_EQ(a.tags.size(), b.tags.size());
  for (std::size_t t = 0; t < a.tags.size(); ++t) {
    EXPECT_EQ(a.tags[t].id, b.tags[t].id);
    EXPECT_EQ(a.tags[t].used, b.tags[t].used);
    expect_same_bits(a.tags[t].residual_px, b.tags[t].residual_px, "residual_px");
    for (int k = 0; k < 4; ++k) expect_same_range(a.tags[t].corners[k], b.tags[t].corners[k], "corner");
  }
  EXPECT_EQ(a.light.kind, b.light.kind);
  expect_same_range(a.light.position, b.light.position, "light.position");
  expect_same_range(a.light.rgb, b.light.rgb, "light.rgb");
  EXPECT_EQ(a.verdict, b.verdict);
  EXPECT_EQ(a.purpose, b.purpose);
  EXPECT_EQ(a.calibration_hash, b.calibration_hash);
  EXPECT_EQ(a.stage_hash, b.stage_hash);
}

}  // namespace sheen::testing
