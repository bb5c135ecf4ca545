// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "common/camera/camera.h"
#include "common/camera/rigid3.h"
#include "common/capture/lighting.h"
#include "common/image/image.h"
#include "common/image/photometry.h"
#include "common/image/raw_image.h"

namespace sheen {

/// What became of a frame's pose, and so why a frame was or was not used. `kTracked` and `kGiven` have a usable pose.
enum class PoseStatus : std::uint8_t {
  kUnspecified = 0,
  kTracked = 1,       ///< solved from the stage's tags
  kGiven = 2,         ///< came with the data
  kNoTags = 3,        ///< no tag of the stage was found
  kTooFewTags = 4,    ///< fewer than the gate asks for
  kInconsistent = 5,  ///< the tags do not agree on one pose
};
const char* to_string(PoseStatus status);

/// What the tracker decided about a frame. Everything but `kKeyframe` is a reason why it was not sent to be kept.
enum class FrameVerdict : std::uint8_t {
  kUnspecified = 0,
  kKeyframe = 1,
  kNoPose = 2,  ///< see PoseStatus
  kTooFewTags = 3,
  kMotionBlur = 4,
  kOverexposed = 5,
  kUnderexposed = 6,
  kTooNear = 7,        ///< hardly differs from an earlier keyframe's view
  kUncertainPose = 8,  ///< the pose's uncertainty on the object is too large
  kIncomplete = 9,     ///< packets of the frame were lost on the camera link
};
const char* to_string(FrameVerdict verdict);

/// Whether an image is added to the model or held out to judge it.
enum class Purpose : std::uint8_t {
  kUnspecified = 0,  ///< the reconstructor decides (every Nth image is held out)
  kTraining = 1,
  kHeldOut = 2,
};

struct TagObservation {
  int id = -1;
  std::array<Eigen::Vector2d, 4> corners;  ///< pixels, in the order of `StageTag::corners_object`
  double residual_px = 0;                  ///< RMS reprojection error under the frame's pose
  bool used = false;                       ///< whether the pose rests on it
};

struct PoseEstimate {
  PoseStatus status = PoseStatus::kUnspecified;
  Rigid3 camera_from_object;
  /// Of a small rotation vector (rad) and translation (m) applied on the left of `camera_from_object`: (w, t).
  Eigen::Matrix<double, 6, 6> covariance = Eigen::Matrix<double, 6, 6>::Zero();
  double reprojection_rms_px = 0;
  double blur_px = 0;  ///< estimated length of the motion streak on the object
  int tags_used = 0;

  bool usable() const { return status == PoseStatus::kTracked || status == PoseStatus::kGiven; }
};

/// Camera settings that decide what a grey level means. `config_epoch` counts every change of any of them.
struct Exposure {
  double exposure_s = 0;  ///< 0 = unknown
  double gain_db = 0;
  std::array<float, 3> white_balance{1, 1, 1};
  float black_level = 0;  ///< of full scale, 0..1
  bool locked = false;    ///< exposure, gain and white balance were fixed and read back
  std::uint32_t config_epoch = 0;
};

/// Nanoseconds; each clock has its own origin, so only differences of one clock mean anything.
struct FrameTimes {
  std::int64_t device_ns = 0;    ///< camera clock
  std::int64_t grabbed_ns = 0;   ///< tracker's steady clock
  std::int64_t sent_ns = 0;      ///< tracker's steady clock
  std::int64_t received_ns = 0;  ///< reconstructor's steady clock
};

/// One image with all that is needed to use it: what the tracker sends, what the journal keeps, what a model ingests.
struct Capture {
  std::string source_session;  ///< identifies one run of one source; (source_session, sequence) is unique
  std::uint64_t sequence = 0;  ///< gap-free among the captures of a source_session, from 1
  std::uint64_t camera_frame_id = 0;
  std::string name;  ///< file name in a dataset, else a label a person can find it by
  FrameTimes times;
  Camera camera;
  RawImage image;
  ImageU8 mask;  ///< empty, or 1 channel of the image's size: 0 = ignore the pixel
  Exposure exposure;
  std::optional<Photometry> photometry;  ///< empty: nobody measured what the camera makes of light
  PoseEstimate pose;
  std::vector<TagObservation> tags;
  LightState light;
  FrameVerdict verdict = FrameVerdict::kUnspecified;
  Purpose purpose = Purpose::kUnspecified;
  std::string calibration_hash;  ///< of the intrinsics in use
  std::string stage_hash;        ///< of the stage layout in use; empty when the pose was given
};

}  // namespace sheen
