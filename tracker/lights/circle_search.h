// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "common/image/image.h"
#include "tracker/lights/ball_view.h"

namespace sheen {

/// Looks for circles whose outline stands still in many pictures of one scene, however the light moves: gradients of
/// all pictures are added up as structure tensors, in which contrasts of either sign support an edge, while noise and
/// moving shadows do not; then edges vote for centres (Hough). Works on small copies: right to a hundredth of the
/// width.
class CircleSearch {
 public:
  /// Linear light, 1 channel, all of one size.
  void add(const ImageF& light);
  /// At most `most`, the best supported first; their outlines may be partly outside the picture.
  std::vector<BallCircle> circles(std::size_t most) const;

 private:
  double scale_ = 1;  ///< of the small copies
  ImageF xx_, xy_, yy_;
};

}  // namespace sheen
