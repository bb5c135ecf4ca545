// SPDX-License-Identifier: Apache-2.0
#include "common/capture/frame_advice.h"

namespace sheen {

const char* advice(FrameVerdict verdict) {
  switch (verdict) {
    case FrameVerdict::kNoPose:
      return "no pose: the stage's tags must be in the picture and sharp";
    case FrameVerdict::kTooFewTags:
      return "too few tags: show more of the stage";
    case FrameVerdict::kMotionBlur:
      return "too fast: motion blur";
    case FrameVerdict::kOverexposed:
      return "too bright: shorten the exposure";
    case FrameVerdict::kUnderexposed:
      return "too dark: lengthen the exposure, or add light";
    case FrameVerdict::kUncertainPose:
      return "uncertain pose: show more of the stage, come nearer, or allow more";
    case FrameVerdict::kIncomplete:
      return "frames arrive incomplete: sheen-tracker doctor checks the camera's network";
    case FrameVerdict::kKeyframe:
    case FrameVerdict::kTooNear:
    case FrameVerdict::kUnspecified:
      break;
  }
  return "";
}

}  // namespace sheen
