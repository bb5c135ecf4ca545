// SPDX-License-Identifier: Apache-2.0
#include "tests/support/sample_capture.h"

#include <random>
#include "tests/support/camera_responses.h"

namespace sheen::testing {
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
  c.photometry =
      Photometry{srgb_response(0.02), {width / 2.0, height / 3.0, {-0.25, 0.03, -0.004}}, {1.8f, 1, 1.3f}, 0.97f};
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

}  // namespace sheen::testing
