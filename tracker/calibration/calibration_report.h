// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>

#include "tracker/calibration/calibration_study.h"
#include "tracker/calibration/target.h"
#include "tracker/calibration/view_advice.h"

namespace sheen {

/// What a person reads.
std::string calibration_text(const CalibrationStudy& study, const ViewAdvice& advice);
/// What a program reads.
std::string calibration_json(const CalibrationStudy& study, const ViewAdvice& advice, const CalibrationTarget& target);

}  // namespace sheen
