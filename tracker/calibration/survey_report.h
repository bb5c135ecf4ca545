// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "tracker/calibration/survey_judgement.h"

namespace sheen {

/// What a person reads.
std::string survey_text(const StageSurvey& survey, const SurveyQuality& quality,
                        const std::vector<SurveyFinding>& findings);
/// What a program reads.
std::string survey_json(const StageSurvey& survey, const SurveyQuality& quality,
                        const std::vector<SurveyFinding>& findings);

}  // namespace sheen
