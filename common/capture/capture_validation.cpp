// SPDX-License-Identifier: Apache-2.0
#include "common/capture/capture_validation.h"

#include <cmath>
#include <cstdint>
#include <limits>

#include "common/base/length_limit.h"

namespace sheen {
namespace {

constexpr std::size_t kMaxNameBytes = 1024, kMaxIdBytes = 128;
constexpr double kMaxPixel = 1e7;
constexpr double kUnitTolerance = 1e-6;
constexpr double kSymmetryTolerance = 1e-6;
constexpr double kDirectionTolerance = 1e-3;
constexpr int kMaxTagId = 1 << 20;

/// Says what is wrong with the first of a row of checks that fails.
class Checks {
 public:
  void require(bool holds, const char* field, const char* rule) {
    if (!holds && error_.empty()) error_ = std::string(field) + " " + rule;
  }
  void within(double value, double low, double high, const char* field) {
    if (value >= low && value <= high) return;  // false for NaN
    if (error_.empty())
      error_ =
          std::string(field) + " must be finite and between " + std::to_string(low) + " and " + std::to_string(high);
  }
  void text(const std::string& value, std::size_t max_bytes, const char* field) {
    require(value.size() <= max_bytes, field, "is too long");
    require(is_plain_text(value), field, "must be UTF-8 without control characters");
  }
  void inherit(const std::string& error) {
    if (error_.empty()) error_ = error;
  }
  const std::string& error() const { return error_; }

 private:
  std::string error_;
};

template <typename Enum>
bool known(Enum value, Enum last) {
  return static_cast<int>(value) >= 0 && static_cast<int>(value) <= static_cast<int>(last);
}

void check_covariance(Checks& checks, const Eigen::Matrix<double, 6, 6>& covariance) {
  checks.require(covariance.allFinite(), "pose.covariance", "must be finite");
  checks.require((covariance.diagonal().array() >= 0).all(), "pose.covariance", "has a negative variance");
  if (!checks.error().empty()) return;
  const Eigen::Matrix<double, 6, 1> sigma = covariance.diagonal().cwiseSqrt();
  for (int i = 0; i < 6; ++i)
    for (int j = 0; j < i; ++j) {
      const double scale = sigma[i] * sigma[j];
      checks.require(std::abs(covariance(i, j) - covariance(j, i)) <= kSymmetryTolerance * scale, "pose.covariance",
                     "must be symmetric");
      checks.require(std::abs(covariance(i, j)) <= (1 + kSymmetryTolerance) * scale, "pose.covariance",
                     "has a correlation beyond one");
    }
}

void check_pose(Checks& checks, const PoseEstimate& pose) {
  checks.require(known(pose.status, PoseStatus::kInconsistent), "pose.status", "is unknown");
  const double norm = pose.camera_from_object.rotation.norm();
  checks.require(std::abs(norm - 1) <= kUnitTolerance, "pose.rotation", "must be a unit quaternion");
  for (const double t : pose.camera_from_object.translation)
    checks.within(t, -kLongestLength, kLongestLength, "pose.translation");
  check_covariance(checks, pose.covariance);
  checks.within(pose.reprojection_rms_px, 0, kMaxPixel, "pose.reprojection_rms_px");
  checks.within(pose.blur_px, 0, kMaxPixel, "pose.blur_px");
  checks.within(pose.tags_used, 0, kMaxTags, "pose.tags_used");
}

void check_tags(Checks& checks, const std::vector<TagObservation>& tags) {
  checks.require(tags.size() <= kMaxTags, "tags", "are too many");
  for (const TagObservation& tag : tags) {
    checks.within(tag.id, 0, kMaxTagId, "tags.id");
    for (const Eigen::Vector2d& corner : tag.corners) {
      checks.within(corner.x(), -kMaxPixel, kMaxPixel, "tags.corners");
      checks.within(corner.y(), -kMaxPixel, kMaxPixel, "tags.corners");
    }
    checks.within(tag.residual_px, 0, kMaxPixel, "tags.residual_px");
  }
}

void check_exposure(Checks& checks, const Exposure& exposure) {
  checks.within(exposure.exposure_s, 0, 1e5, "exposure.exposure_s");
  checks.within(exposure.gain_db, -200, 200, "exposure.gain_db");
  for (const float gain : exposure.white_balance) checks.within(gain, 0, 1e4, "exposure.white_balance");
  checks.require(exposure.black_level >= 0 && exposure.black_level < 1, "exposure.black_level",
                 "must be at least 0 and below 1");
}

void check_light(Checks& checks, const LightState& light) {
  checks.require(known(light.kind, LightKind::kEnvironment), "light.kind", "is unknown");
  for (const double p : light.position) checks.within(p, -kLongestLength, kLongestLength, "light.position");
  if (light.kind == LightKind::kDirectional)
    checks.require(std::abs(light.position.norm() - 1) <= kDirectionTolerance, "light.position",
                   "must be a unit vector for a directional light");
  for (const float value : light.rgb) checks.within(value, 0, 1e9, "light.rgb");
}

}  // namespace

bool is_plain_text(const std::string& text) {
  const auto byte = [&](std::size_t i) { return static_cast<std::uint8_t>(text[i]); };
  for (std::size_t i = 0; i < text.size();) {
    const std::uint8_t lead = byte(i);
    if (lead < 0x20 || lead == 0x7F) return false;
    const int more = lead < 0x80             ? 0
                     : (lead & 0xE0) == 0xC0 ? 1
                     : (lead & 0xF0) == 0xE0 ? 2
                     : (lead & 0xF8) == 0xF0 ? 3
                                             : -1;
    if (more < 0 || i + more >= text.size()) return false;
    std::uint32_t code = more == 0 ? lead : lead & (0x3F >> more);
    for (int k = 1; k <= more; ++k) {
      if ((byte(i + k) & 0xC0) != 0x80) return false;
      code = code << 6 | (byte(i + k) & 0x3F);
    }
    constexpr std::uint32_t kSmallest[] = {0, 0x80, 0x800, 0x10000};
    if (code < kSmallest[more] || code > 0x10FFFF || (code >= 0xD800 && code < 0xE000)) return false;
    i += more + 1;
  }
  return true;
}

std::string size_error(const RawImage& image, int mask_width, int mask_height) {
  const std::size_t pixel = bytes_per_pixel(image.format);
  constexpr int kMaxSide = 1 << 16;
  Checks checks;
  checks.require(pixel > 0, "image.format", "is unknown");
  checks.require(image.transfer == Transfer::kLinear || image.transfer == Transfer::kSrgb, "image.transfer",
                 "is unknown");
  checks.within(image.width, 1, kMaxSide, "image.width");
  checks.within(image.height, 1, kMaxSide, "image.height");
  if (!checks.error().empty()) return checks.error();
  checks.within(static_cast<double>(image.stride), static_cast<double>(image.width * pixel), 1 << 24, "image.stride");
  const bool has_mask = mask_width != 0 || mask_height != 0;
  checks.require(!has_mask || (mask_width == image.width && mask_height == image.height), "mask",
                 "must have the image's size");
  const std::size_t mask_bytes = has_mask ? std::size_t(image.width) * image.height : 0;
  checks.require(image.stride * image.height + mask_bytes <= kMaxPixelBytes, "image", "is larger than 256 MiB");
  return checks.error();
}

std::string validation_error(const Capture& capture) {
  Checks checks;
  checks.require(!capture.source_session.empty(), "source_session", "is missing");
  checks.text(capture.source_session, kMaxIdBytes, "source_session");
  checks.require(capture.sequence <= std::uint64_t(std::numeric_limits<std::int64_t>::max()), "sequence",
                 "is too large");
  checks.text(capture.name, kMaxNameBytes, "name");
  checks.text(capture.calibration_hash, kMaxIdBytes, "calibration_hash");
  checks.text(capture.stage_hash, kMaxIdBytes, "stage_hash");
  checks.inherit(size_error(capture.image, capture.mask.width(), capture.mask.height()));
  checks.require(capture.mask.empty() || capture.mask.channels() == 1, "mask", "must have one channel");
  checks.inherit(validation_error(capture.image));
  checks.require(capture.camera.lens == LensModel::kOpenCv || capture.camera.lens == LensModel::kFisheye, "camera.lens",
                 "is unknown");
  checks.inherit(validation_error(capture.camera));
  checks.require(capture.camera.width == capture.image.width && capture.camera.height == capture.image.height, "camera",
                 "must have the image's size");
  check_exposure(checks, capture.exposure);
  if (capture.photometry)
    checks.inherit(validation_error(*capture.photometry, {capture.image.width, capture.image.height}));
  check_pose(checks, capture.pose);
  check_tags(checks, capture.tags);
  check_light(checks, capture.light);
  checks.require(known(capture.verdict, FrameVerdict::kIncomplete), "verdict", "is unknown");
  checks.require(known(capture.purpose, Purpose::kHeldOut), "purpose", "is unknown");
  return checks.error();
}

}  // namespace sheen
