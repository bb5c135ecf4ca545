// SPDX-License-Identifier: Apache-2.0
#include "tracker/pose/stage_finder.h"

#include "common/base/stage_clock.h"

namespace sheen {
namespace {

constexpr float kCoarseWidth_px = 256;  ///< a stage that fills the image still shows most of its tags
constexpr int kEnoughTags = 4;          ///< their pose puts the other tags to within the reach of the edge fit
constexpr int kLooks = 2;               ///< the first pose may rest on one end of the stage; the second does not

}  // namespace

StageFinder::StageFinder(const Camera& camera, const StageLayout& stage, const StageFinderOptions& options)
    : camera_(camera), stage_(stage), options_(options), expected_(stage) {
  DetectorOptions detector = options.detector;
  if (!options.other_tags)
    while (2 * detector.quad_decimate * kCoarseWidth_px <= static_cast<float>(camera.width))
      detector.quad_decimate *= 2;
  for (; detector.quad_decimate >= options.detector.quad_decimate; detector.quad_decimate /= 2)
    detectors_.emplace_back(detector);
}

StageSighting StageFinder::find(const ImageU8& grey) {
  StageSighting sighting;
  std::vector<TagObservation>& tags = sighting.tags;
  PoseEstimate& pose = sighting.pose;
  StageClock clock(sighting.stage_ms);
  const auto refine = [&](std::vector<TagObservation>& some) {
    refine_corners(grey, camera_, some, options_.refiner);
    clock.done("refine");
  };
  const auto solve = [&] {
    pose = solve_pose(camera_, stage_, tags, options_.pose);
    clock.done("solve");
  };
  for (TagDetector& detector : detectors_) {
    tags = detector.detect(grey);
    clock.done("detect");
    refine(tags);
    solve();
    if (pose.usable() && pose.tags_used >= kEnoughTags) break;
  }
  for (int look = 0; look < kLooks && pose.usable(); ++look) {
    std::vector<TagObservation> more = expected_.missing(grey, camera_, pose.camera_from_object, tags);
    clock.done("detect");
    refine(more);
    if (more.empty()) break;
    tags.insert(tags.end(), more.begin(), more.end());
    solve();
  }
  return sighting;
}

}  // namespace sheen
