// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <span>
#include <string>
#include <vector>

#include "common/camera/camera_file.h"
#include "common/capture/capture.h"
#include "common/geometry/similarity.h"
#include "common/stage/stage_layout.h"

namespace sheen {

/// A distance that was measured with a ruler, from the middle of one tag to the middle of another.
struct MeasuredLength {
  int from_tag = 0, to_tag = 0;
  double metres = 0;
  double uncertainty_m = 0.25e-3;  ///< standard deviation; a steel ruler, read to half a millimetre
};
/// "tag 3 to tag 7: 200mm" or "tag 3 to tag 7: 200mm +- 0.1mm". Throws ConfigError.
MeasuredLength parse_measured_length(const std::string& text);

/// An image of the stage: its tags with corners that are refined.
struct SurveyImage {
  std::string name;
  std::vector<TagObservation> tags;
};

/// What became of an image.
struct SurveyedImage {
  std::string name;
  bool used = false;
  std::string reason;  ///< why it is not used
  Rigid3 camera_from_object;
  int tags = 0;
  double rms_px = 0;
};

/// Where one tag stands. Its four corners are free points: nothing is believed of the print.
struct SurveyedTag {
  int id = 0;
  bool surveyed = false;
  std::string reason;   ///< why it is not: seen too seldom, or not in one place
  int images = 0;       ///< that it is used in
  int disagreeing = 0;  ///< images in which it stood elsewhere
  double rms_px = 0;
  Eigen::Vector3d shift_m = Eigen::Vector3d::Zero();  ///< of its middle, from the sheet as it was printed (scaled)
  double tilt_deg = 0;                                ///< of its plane out of the sheet's
  double turn_deg = 0;                                ///< in the sheet's plane
  double shift_uncertainty_m = 0, tilt_uncertainty_deg = 0;  ///< standard deviations, the worst direction
};

/// The stage as it is. Frame: that of the sheet, moved onto what was found by the similarity that fits best.
struct StageSurvey {
  StageLayout stage;  ///< of the tags surveyed
  std::vector<SurveyedTag> tags;
  std::vector<SurveyedImage> images;
  double rms_px = 0;                        ///< of the distance of a corner from its prediction
  double noise_px = 0;                      ///< standard deviation of a coordinate
  double scale = 1, scale_uncertainty = 0;  ///< of the sheet as printed, that of the length included
  /// Of the corners of `stage`, 3 numbers each, in its order; m^2. The length's uncertainty is included.
  Eigen::MatrixXd covariance;
  /// Of the focal length, if it is estimated too: ratio to the one given, and its standard deviation.
  double focal_ratio = 1, focal_uncertainty = 0;
  /// Sightings that it rests on, tags by their index in `stage`: for what is derived from it.
  struct Sighting {
    int image = 0, tag = 0;  ///< of `images`, of `stage.tags`
    std::array<Eigen::Vector2d, 4> corners;
  };
  std::vector<Sighting> sightings;
};

struct SurveyOptions {
  int fewest_images = 5;      ///< in all
  int fewest_tags = 4;        ///< of an image
  int fewest_sightings = 3;   ///< of a tag
  double outlier_sigmas = 6;  ///< of a tag in an image (RMS of its corners)
  double outlier_floor_px = 0.1;
  double most_disagreeing = 0.15;  ///< part of a tag's images in which it may be off before it counts as not fixed
};

/// Bundle adjustment of poses and tags, camera given; scale from the measured length. Tags that do not stay in one
/// place are left out. Throws Error when there are too few images or tags, or the measured ones are not among them.
StageSurvey survey_stage(const Camera& camera, const StageLayout& printed, std::span<const SurveyImage> images,
                         const MeasuredLength& length, const SurveyOptions& options = {});

}  // namespace sheen
