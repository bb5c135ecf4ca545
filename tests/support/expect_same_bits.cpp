// SPDX-License-Identifier: Apache-2.0
#include "tests/support/expect_same_bits.h"

#include <gtest/gtest.h>

#include <bit>
#include <cstdint>

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
  EXPECT_EQ(a.photometry, b.photometry);
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
