// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <string>
#include <vector>

#include "common/camera/camera.h"
#include "common/capture/capture.h"
#include "common/stage/stage_layout.h"
#include "tracker/fiducials/corner_refiner.h"
#include "tracker/fiducials/expected_tags.h"
#include "tracker/fiducials/tag_detector.h"
#include "tracker/pose/pose_solver.h"

namespace sheen {

struct StageFinderOptions {
  DetectorOptions detector;
  RefinerOptions refiner;
  PoseOptions pose;
  bool other_tags = false;  ///< tags that are not on the stage are wanted, too; costs the full search in every image
};

/// A stage in an image.
struct StageSighting {
  std::vector<TagObservation> tags;
  PoseEstimate pose;
  std::map<std::string, double> stage_ms;  ///< time per step: detect, refine, solve
};

/// Finds a stage coarse to fine. Tags are searched in an image so small that a few remain; the pose that they determine
/// says where the others are, and each is read there at full resolution. So the search, which is most of the work,
/// costs a fraction. Where a coarse image does not show enough tags, the next finer one is searched, down to
/// `detector.quad_decimate`.
class StageFinder {
 public:
  StageFinder(const Camera& camera, const StageLayout& stage, const StageFinderOptions& options = {});

  StageSighting find(const ImageU8& grey);

 private:
  Camera camera_;
  StageLayout stage_;
  StageFinderOptions options_;
  ExpectedTags expected_;
  std::vector<TagDetector> detectors_;  ///< the coarsest first
};

}  // namespace sheen
