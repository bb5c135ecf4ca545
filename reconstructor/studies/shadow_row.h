// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <vector>

#include "common/image/image.h"
#include "reconstructor/lumigraph_file/intrinsic_view.h"
#include "reconstructor/studies/still_life.h"

namespace sheen {

const IntrinsicView& central_view(const StillLife& scene);

/// 255 less each value: shadow for what arrives, and back.
ImageU8 inverse(ImageU8 image);

/// Of shadows: where at most half of a lamp's light arrives.
double iou(const ImageU8& shadow, const ImageU8& truth);

/// A scene in lights between two captured ones, in equal steps; both ends are captured lights.
struct ShadowRow {
  static constexpr int kSteps = 8;  ///< from one captured light to the next

  std::vector<double> places;  ///< of the lights in the rig's row (`LightRig::light_at`)
  // Shadow per light, 255 in full.
  std::vector<ImageU8> truth;
  std::vector<ImageU8> geometric;  ///< of the view's depth map alone
  std::vector<ImageU8> warped;     ///< the paper's
  std::vector<ImageU8> lumigraph;
  std::vector<ImageU8> linear;
};
ShadowRow shadows_between(const StillLife& scene, std::size_t first_light);

}  // namespace sheen
