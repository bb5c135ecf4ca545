// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "tracker/sources/camera_features.h"

namespace sheen {

/// A feature that another program, or the camera's own start, had left in another state.
struct ResetFeature {
  LockedFeature now;
  std::string was;
};

/// Undoes what a camera may have kept and what would change its images without a word: a trigger, another acquisition
/// or exposure mode, mirrored axes, binning and decimation, a test pattern, a table of values, chunks of data behind
/// the image. What is as it should be is not written to; what the camera lacks or does not say is left alone.
std::vector<ResetFeature> reset_camera(_ArvCamera* camera);

/// "ReverseX was on, is off; ..."; empty when there were none.
std::string reset_text(const std::vector<ResetFeature>& features);

}  // namespace sheen
