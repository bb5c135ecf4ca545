// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "common/capture/capture.h"

namespace sheen {

/// What the person who holds the camera should know of a verdict: "too fast: motion blur". Empty for a keyframe, and
/// for one that is only near an earlier one.
const char* advice(FrameVerdict verdict);

}  // namespace sheen
