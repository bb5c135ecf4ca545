// SPDX-License-Identifier: Apache-2.0
#include "tracker/pose/keyframe_gate.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <string>

#include "common/base/angle.h"
#include "tracker/pose/pose_solver.h"

namespace sheen {
namespace {

constexpr double kMaxGap_s = 0.5;  ///< beyond it the last motion says nothing about this one
constexpr int kPixelStep = 3;      ///< odd, so that every colour site takes part
constexpr int kFullScale = 255;

/// Points that stand for the object: the region's centre and its extremes along the axes.
std::array<Eigen::Vector3d, 7> probes(const ObjectRegion& region) {
  std::array<Eigen::Vector3d, 7> points;
  points.fill(region.centre);
  for (int axis = 0; axis < 3; ++axis) {
    points[1 + 2 * axis][axis] += region.radius_m;
    points[2 + 2 * axis][axis] -= region.radius_m;
  }
  return points;
}

struct Box {
  int x0, y0, x1, y1;  ///< half open
};

/// Bounding box of the region in the image; empty (x0 >= x1) where it is not seen.
Box image_box(const Camera& camera, const Rigid3& pose, const ObjectRegion& region) {
  Box box{camera.width, camera.height, 0, 0};
  for (const Eigen::Vector3d& point : probes(region))
    if (const auto p = camera.project(pose * point)) {
      box.x0 = std::min(box.x0, static_cast<int>(std::clamp(p->x(), 0.0, camera.width - 1.0)));
      box.y0 = std::min(box.y0, static_cast<int>(std::clamp(p->y(), 0.0, camera.height - 1.0)));
      box.x1 = std::max(box.x1, static_cast<int>(std::clamp(p->x(), 0.0, camera.width - 1.0)) + 1);
      box.y1 = std::max(box.y1, static_cast<int>(std::clamp(p->y(), 0.0, camera.height - 1.0)) + 1);
    }
  return box;
}

}  // namespace

std::string validation_error(const GateOptions& o) {
  if (!(o.min_tags >= 2 && o.min_tags <= 587)) return "min_tags must be 2..587, as many as the family has";
  if (!(o.max_blur_px >= 0.01 && o.max_blur_px <= 1000)) return "max_blur_px must lie in 0.01..1000";
  if (!(o.max_overexposed > 0 && o.max_overexposed <= 1)) return "max_overexposed must lie in 0..1";
  if (!(o.min_bright >= 0 && o.min_bright < 1)) return "min_bright must lie in 0..1";
  if (!(o.min_angle_deg >= 0 && o.min_angle_deg < 180)) return "min_angle_deg must lie in 0..180";
  if (!(o.min_distance_m >= 0 && o.min_distance_m <= 1000)) return "min_distance_m must lie in 0..1000";
  if (o.max_uncertainty_px != 0 && !(o.max_uncertainty_px >= 0.001 && o.max_uncertainty_px <= 1000))
    return "max_uncertainty_px must lie in 0.001..1000";
  return {};
}

ObjectRegion object_region(const StageLayout& stage) {
  const double radius = std::min(stage.width_m, stage.height_m) / 4;
  return {.centre = {0, 0, radius}, .radius_m = radius};
}

double predicted_blur_px(const Camera& camera, const ObjectRegion& region, const Rigid3& before, const Rigid3& now,
                         double interval_s, double exposure_s) {
  if (!(interval_s > 0) || !(exposure_s > 0)) return 0;
  const Rigid3 motion = now * before.inverse();  // in the camera's frame, over the interval
  const Eigen::AngleAxisd turn(motion.rotation);
  const double part = exposure_s / interval_s;
  Eigen::Matrix<double, 6, 1> step;
  step << turn.axis() * turn.angle() * part, motion.translation * part;
  const Rigid3 after = moved(now, step);
  double longest = 0;
  for (const Eigen::Vector3d& point : probes(region)) {
    const auto a = camera.project(now * point), b = camera.project(after * point);
    if (a && b) longest = std::max(longest, (*b - *a).norm());
  }
  return longest;
}

double BlurPredictor::predict(const Camera& camera, const ObjectRegion& region, const Rigid3& pose,
                              std::int64_t device_ns, double exposure_s) {
  const std::optional<Sighting> before = last_;
  last_ = Sighting{pose, device_ns};
  if (!before) return 0;
  const double interval_s = (device_ns - before->device_ns) * 1e-9;
  if (interval_s > kMaxGap_s) return 0;
  return predicted_blur_px(camera, region, before->pose, pose, interval_s, exposure_s);
}

KeyframeGate::KeyframeGate(const GateOptions& options, const ObjectRegion& region)
    : options_(options), region_(region) {
  if (options_.max_uncertainty_px == 0) options_.max_uncertainty_px = kCameraUncertainty_px;
}

FrameVerdict KeyframeGate::judge(const Camera& camera, const RawImage& image, bool complete, const PoseEstimate& pose,
                                 const LightState& light) const {
  if (!complete) return FrameVerdict::kIncomplete;
  if (!pose.usable()) return FrameVerdict::kNoPose;
  if (pose.tags_used < options_.min_tags) return FrameVerdict::kTooFewTags;
  if (pose.blur_px > options_.max_blur_px) return FrameVerdict::kMotionBlur;
  const FrameVerdict exposure = judge_exposure(camera, image, pose.camera_from_object);
  if (exposure != FrameVerdict::kKeyframe) return exposure;
  if (!(uncertainty_px(camera, pose) <= options_.max_uncertainty_px)) return FrameVerdict::kUncertainPose;
  return too_near(pose.camera_from_object, light) ? FrameVerdict::kTooNear : FrameVerdict::kKeyframe;
}

double KeyframeGate::uncertainty_px(const Camera& camera, const PoseEstimate& pose) const {
  double largest = 0;
  for (const Eigen::Vector3d& point : probes(region_)) {
    const double here = point_uncertainty_px(camera, pose, point);
    if (!(here <= largest)) largest = here;  // NaN, too
  }
  return largest;
}

void KeyframeGate::remember(const PoseEstimate& pose, const LightState& light) {
  keyframes_.push_back({pose.camera_from_object, light});
}

FrameVerdict KeyframeGate::judge_exposure(const Camera& camera, const RawImage& image, const Rigid3& pose) const {
  if (image.format == PixelFormat::kRGB32f) return FrameVerdict::kKeyframe;  // has no full scale
  const Box box = image_box(camera, pose, region_);
  const std::size_t pixel = bytes_per_pixel(image.format);
  std::array<std::size_t, kFullScale + 1> histogram{};
  std::size_t count = 0;
  for (int y = box.y0; y < box.y1; y += kPixelStep)
    for (int x = box.x0; x < box.x1; x += kPixelStep, ++count) {
      const std::uint8_t* p = image.bytes.data() + y * image.stride + x * pixel;
      ++histogram[*std::max_element(p, p + pixel)];
    }
  if (count == 0) return FrameVerdict::kKeyframe;
  if (histogram[kFullScale] > options_.max_overexposed * count) return FrameVerdict::kOverexposed;
  std::size_t above = 0;
  int p99 = kFullScale;
  for (; p99 > 0; --p99)
    if ((above += histogram[p99]) * 100 >= count) break;
  return p99 < options_.min_bright * kFullScale ? FrameVerdict::kUnderexposed : FrameVerdict::kKeyframe;
}

bool KeyframeGate::same_light(const LightState& a, const LightState& b) const {
  if (a.kind != b.kind) return false;
  if (a.kind == LightKind::kDirectional) return a.position.dot(b.position) > std::cos(options_.min_angle_deg * kDegree);
  return (a.position - b.position).norm() < options_.min_distance_m || a.position == b.position;
}

bool KeyframeGate::too_near(const Rigid3& pose, const LightState& light) const {
  const Eigen::Vector3d eye = camera_centre(pose);
  const double min_cosine = std::cos(options_.min_angle_deg * kDegree);
  return std::ranges::any_of(keyframes_, [&](const Keyframe& keyframe) {
    if (!same_light(keyframe.light, light)) return false;
    const Eigen::Vector3d other = camera_centre(keyframe.pose);
    const double cosine = (eye - region_.centre).normalized().dot((other - region_.centre).normalized());
    return (eye - other).norm() < options_.min_distance_m && cosine > min_cosine;
  });
}

}  // namespace sheen
