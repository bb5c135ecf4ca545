// SPDX-License-Identifier: Apache-2.0
#include "common/capture/capture.h"

namespace sheen {

const char* to_string(PoseStatus status) {
  switch (status) {
    case PoseStatus::kTracked:
      return "tracked";
    case PoseStatus::kGiven:
      return "given";
    case PoseStatus::kNoTags:
      return "no_tags";
    case PoseStatus::kTooFewTags:
      return "too_few_tags";
    case PoseStatus::kInconsistent:
      return "inconsistent";
    case PoseStatus::kUnspecified:
      break;
  }
  return "unspecified";
}

const char* to_string(FrameVerdict verdict) {
  switch (verdict) {
    case FrameVerdict::kKeyframe:
      return "keyframe";
    case FrameVerdict::kNoPose:
      return "no_pose";
    case FrameVerdict::kTooFewTags:
      return "too_few_tags";
    case FrameVerdict::kMotionBlur:
      return "motion_blur";
    case FrameVerdict::kOverexposed:
      return "overexposed";
    case FrameVerdict::kUnderexposed:
      return "underexposed";
    case FrameVerdict::kTooNear:
      return "too_near";
    case FrameVerdict::kUncertainPose:
      return "uncertain_pose";
    case FrameVerdict::kIncomplete:
      return "incomplete";
    case FrameVerdict::kUnspecified:
      break;
  }
  return "unspecified";
}

}  // namespace sheen
