// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "common/camera/camera.h"
#include "common/camera/rigid3.h"
#include "common/capture/capture.h"
#include "common/stage/stage_layout.h"
#include "common/stage/tag_pattern.h"

namespace sheen {

/// Where a pose says that a stage's tags are seen, they are looked for: a few tags that were found in a coarse image
/// lead to all the others.
class ExpectedTags {
 public:
  explicit ExpectedTags(const StageLayout& stage);

  /// The tags of the stage that are not among `found` and whose code is read at full resolution where the pose puts
  /// them, with the corners that it predicts. As the detector, it forgives one wrong cell.
  std::vector<TagObservation> missing(const ImageU8& grey, const Camera& camera, const Rigid3& camera_from_object,
                                      const std::vector<TagObservation>& found) const;

 private:
  struct Expected {
    StageTag tag;
    TagPattern pattern;
  };
  std::vector<Expected> expected_;
};

}  // namespace sheen
