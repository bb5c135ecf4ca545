// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "common/camera/camera.h"
#include "tracker/calibration/image_set.h"
#include "tracker/calibration/target.h"

namespace sheen {

/// Finds a target in an image. Points come as far as they are seen (a chessboard: all or none); none: not found.
class TargetFinder {
 public:
  explicit TargetFinder(const CalibrationTarget& target);
  ~TargetFinder();

  /// Edges of tags are straight only without the lens's distortion: with the `camera` as far as it is known, corners
  /// are fitted to them; without, they are as the detector gives them, to about 0.1 px. Other targets need none.
  std::vector<TargetSighting> find(const GreyImage& image, const Camera* camera = nullptr) const;
  bool better_with_camera() const;
  /// What the images so far showed in the target's place, a sentence for a person; empty: nothing that has a name.
  std::string seen_instead() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace sheen
