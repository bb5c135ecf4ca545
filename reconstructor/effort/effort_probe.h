// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <vector>

#include "common/capture/capture.h"
#include "reconstructor/effort/effort_control.h"
#include "reconstructor/evaluation/held_out.h"
#include "reconstructor/models/appearance_model.h"
#include "reconstructor/render/ray_painter.h"

namespace sheen {

/// The first accepted images of a capture with a budget: the effort level for the rest of it is chosen by what they
/// took, and by what is lost on them where nothing was measured before.
class EffortProbe {
 public:
  struct Image {
    Capture capture;
    double held_out_bytes = 0;   ///< of the views held out before it
    float known_gain = 1;        ///< by which the camera says that it is brighter than the model's level
    double predicted_error = 0;  ///< mean square, encoded, of predicting it from those before; NaN where none did
  };
  /// The model that ingests the images.
  struct Trial {
    std::function<void(int)> fold_at;  ///< ingests all images again at an effort level
    std::function<double()> image_ms;  ///< the median time of an image
    /// Mean square, encoded, over the object's pixels of views.
    std::function<double(const std::vector<HeldOutView>&)> error_on;
  };

  void add(const Capture& capture, const IngestReport& report, double held_out_bytes);
  void leave_out(const Capture& capture);
  bool full() const { return images_.size() == EffortControl::kProbeImages; }
  const std::vector<Image>& images() const { return images_; }
  double bytes() const;

  /// The level, of `levels`, at which an image keeps to the budget; the images are then ingested at it.
  int choose(const MeasuredLevels& measured, int begun_at, int levels, double budget_ms, const RayPainter& painter,
             const Trial& trial) const;

 private:
  int coarsest_that_loses_little(int begun_at, int levels, double budget_ms, const RayPainter& painter,
                                 const Trial& trial) const;
  double predicted_error() const;

  std::vector<Image> images_;
};

}  // namespace sheen
