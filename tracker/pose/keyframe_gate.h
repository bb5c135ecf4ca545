// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "common/camera/camera.h"
#include "common/capture/capture.h"
#include "common/stage/stage_layout.h"

namespace sheen {

/// Defaults rest on measurements with a synthetic stage of 24 tags at 0.55 to 0.75 m and f = 1200 px.
struct GateOptions {
  int min_tags = 6;
  double max_blur_px = 2;         ///< 4 px already cost 0.4 mm of the camera's place (p95), 12 px 28 mm
  double max_overexposed = 0.1;   ///< part of the stage's pixels at full scale; highlights stay well below
  double min_bright = 0.1;        ///< of full scale: the 99th percentile on the stage must reach it
  double min_angle_deg = 1;       ///< a frame is too near when an earlier keyframe differs by less than this ...
  double min_distance_m = 0.01;   ///< ... and by less than this: about 1 deg at 0.6 m; so for a lamp that moves
  double max_uncertainty_px = 0;  ///< standard deviation of where the object appears; 0: what the source allows
};
/// `max_uncertainty_px` where none is given. Compression moves edges: no pose of such a video is as certain as a
/// camera's, and its pictures are no sharper either.
inline constexpr double kCameraUncertainty_px = 0.05, kCompressedUncertainty_px = 0.3;

/// Empty, or which option is out of range.
std::string validation_error(const GateOptions& options);

/// Where the object stands, for judging a pose by what it does to the object and not to the tags.
struct ObjectRegion {
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();
  double radius_m = 0;
};
/// A ball on the middle of the board that touches the board's shorter half.
ObjectRegion object_region(const StageLayout& stage);

/// Length (pixels) of the streak that a point of the object draws during the exposure when the camera goes on moving as
/// it did from `before` to `now`, the longest over the region. Frames are `interval_s` apart.
double predicted_blur_px(const Camera& camera, const ObjectRegion& region, const Rigid3& before, const Rigid3& now,
                         double interval_s, double exposure_s);

/// Remembers the last poses and predicts the blur of each new one. Blur is 0 where nothing is known of the motion: for
/// the first pose, and after half a second without one.
class BlurPredictor {
 public:
  double predict(const Camera& camera, const ObjectRegion& region, const Rigid3& pose, std::int64_t device_ns,
                 double exposure_s);

 private:
  struct Sighting {
    Rigid3 pose;
    std::int64_t device_ns = 0;
  };
  std::optional<Sighting> last_;
};

/// Decides which frames are kept; every refusal has its reason.
class KeyframeGate {
 public:
  KeyframeGate(const GateOptions& options, const ObjectRegion& region);

  /// Judges a frame with its solved pose (blur included) and its light. Does not remember it.
  FrameVerdict judge(const Camera& camera, const RawImage& image, bool complete, const PoseEstimate& pose,
                     const LightState& light = {}) const;
  /// Pixels; the largest over the object.
  double uncertainty_px(const Camera& camera, const PoseEstimate& pose) const;
  double max_uncertainty_px() const { return options_.max_uncertainty_px; }
  /// Remembers a keyframe that was taken, so that its neighbours in the same light are too near.
  void remember(const PoseEstimate& pose, const LightState& light = {});

 private:
  FrameVerdict judge_exposure(const Camera& camera, const RawImage& image, const Rigid3& pose) const;
  bool too_near(const Rigid3& pose, const LightState& light) const;
  bool same_light(const LightState& a, const LightState& b) const;

  GateOptions options_;
  ObjectRegion region_;
  struct Keyframe {
    Rigid3 pose;
    LightState light;
  };
  std::vector<Keyframe> keyframes_;
};

}  // namespace sheen
