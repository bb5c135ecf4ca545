// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "tracker/calibration/calibration_study.h"
#include "tracker/calibration/target.h"
#include "tracker/calibration/target_finder.h"

namespace sheen {

struct ViewCollectorOptions {
  double most_moved_px = 1.5;  ///< between two frames: what moves more is blurred or sheared ...
  double most_blur_px = 0.5;   ///< ... unless its exposure is known to be so short that it moved less during it
  /// A view is kept that leaves at most this part of the uncertainty (RMS over the image).
  double most_left = 0.97;
  double least_change = 0.25;  ///< of the corners, parts of the target's size in the image; until there is a camera
  std::size_t most_views = 60;
};

/// What became of a frame.
enum class SeenView : std::uint8_t { kNoTarget, kMoving, kNothingNew, kKept };

/// Chooses the views of a target that a calibration gains by, while a camera shows them, and knows which is missing.
class ViewCollector {
 public:
  ViewCollector(CalibrationTarget target, ImageSize size, const LensFit& fit, const ViewCollectorOptions& options = {});

  /// `at_s`: when it was taken, by any clock. `exposure_s`: 0 where it is not known.
  SeenView see(const GreyImage& image, double at_s, double exposure_s);
  /// The same of corners that are found.
  SeenView see(TargetView view, double at_s, double exposure_s);

  const std::vector<TargetView>& views() const { return views_; }
  /// With the views so far; null while they do not determine a camera.
  const CalibrationStudy* study() const { return study_ ? &*study_ : nullptr; }
  /// What a person does next.
  const std::string& next_view() const { return next_view_; }
  /// Nothing is missing any more.
  bool complete() const { return complete_; }

 private:
  bool still(const TargetView& view, double at_s, double exposure_s) const;
  bool adds(const TargetView& view) const;
  void estimate();

  CalibrationTarget target_;
  TargetFinder finder_;
  ImageSize size_;
  const LensFit& fit_;
  ViewCollectorOptions options_;
  TargetView last_;
  double last_at_s_ = 0;
  std::vector<TargetView> views_;
  std::optional<CalibrationStudy> study_;
  std::string next_view_;
  bool complete_ = false;
};

}  // namespace sheen
