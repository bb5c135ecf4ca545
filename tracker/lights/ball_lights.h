// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <vector>

#include "common/base/progress.h"
#include "tracker/lights/ball_highlight.h"

namespace sheen {

/// The lights of images of one camera that stands still, by a chrome ball in the scene.
struct BallLights {
  BallOutline outline;
  std::vector<HighlightFinder::Answer> images;  ///< in their order
  std::size_t found() const;
};

/// `read`: linear light of an image, 1 channel; each is read three times. `about`: where in the images the ball is, to
/// a fifth of its radius; empty: it is searched for. Throws Error where there is none: no circle, or none that shows
/// highlights.
BallLights lights_of_ball(const BallView& view, std::size_t images, const std::function<ImageF(std::size_t)>& read,
                          const std::optional<BallCircle>& about, const StepsDone& done = {});

}  // namespace sheen
