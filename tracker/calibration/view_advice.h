// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "tracker/calibration/calibration_study.h"

namespace sheen {

/// Which views a calibration rests on, and which it lacks.
struct ViewAdvice {
  double covered = 0;                  ///< part of the image's 8 x 6 fields in which a corner was seen
  std::vector<std::string> uncovered;  ///< of the image's ninths in which none was: "top left", ...
  /// How far the target was turned out of the image's plane, degrees: about the vertical axis of the image (right edge
  /// nearer is positive) and about the horizontal one (lower edge nearer).
  double least_turn_deg = 0, greatest_turn_deg = 0, least_nod_deg = 0, greatest_nod_deg = 0;
  std::vector<std::string> next;  ///< sentences for a person, the most useful view first; empty: nothing is missing
};
ViewAdvice advise(const CalibrationStudy& study);

/// Why the camera must not be used: too few views, not determined well enough, a target that is not what was said.
/// Empty: it may be.
std::string refusal(const CalibrationStudy& study, const ViewAdvice& advice);

/// What is doubtful about it, sentences for a person.
std::vector<std::string> warnings(const CalibrationStudy& study);

}  // namespace sheen
