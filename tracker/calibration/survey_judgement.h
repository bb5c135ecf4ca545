// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "tracker/calibration/stage_survey.h"

namespace sheen {

enum class SurveyFault : std::uint8_t {
  kPrintScale,   ///< the sheet was printed larger or smaller, or the length was measured wrongly
  kStretched,    ///< along one side more than along the other
  kMovedTag,     ///< stands elsewhere in its plane than on the sheet
  kTiltedTag,    ///< leans out of the sheet's plane, or lies above or below it
  kUnsteadyTag,  ///< stood elsewhere in some of the images; not on the surveyed stage
  kUnseenTag,    ///< seen too seldom; not on the surveyed stage
  kFocalLength,  ///< the camera's does not fit these images; the survey is not to be used
};
const char* to_string(SurveyFault fault);

struct SurveyFinding {
  SurveyFault fault;
  int tag = -1;      ///< if it is about one
  std::string text;  ///< for a person: what, by how much, what to do
};

/// How well the surveyed stage predicts what it was not estimated from.
struct SurveyQuality {
  std::vector<double> left_out_px;  ///< of each tag of the stage: RMS of its corners under poses from all other tags
  double left_out_rms_px = 0;
  /// RMS distance of the corners of two surveys, each from every other image, after a similarity; and what noise
  /// explains of it. Empty with too few images.
  std::optional<double> halves_m, halves_expected_m;
  /// Standard deviation with which a point of the object appears in an image whose pose comes from these tags, as far
  /// as the tags' places are to blame: RMS over images, the worst of the middle and the top of the object's region.
  double object_px = 0, object_m = 0;
};

/// What differs from the printed sheet by more than four standard deviations and by more than a printer and good glue
/// do (0.05 % of the scale, 0.3 mm, 1 degree), and a focal length that is off by more than 0.1 %. `focal_uncertainty`
/// is that of the calibration, a part of the focal length.
std::vector<SurveyFinding> judge_survey(const StageSurvey& survey, const StageLayout& printed,
                                        double focal_uncertainty);

SurveyQuality measure_quality(const Camera& camera, const StageLayout& printed, std::span<const SurveyImage> images,
                              const MeasuredLength& length, const StageSurvey& survey);

}  // namespace sheen
