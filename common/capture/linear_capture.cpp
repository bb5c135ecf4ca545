// SPDX-License-Identifier: Apache-2.0
#include "common/capture/linear_capture.h"

namespace sheen {

LinearReader linear_reader(const Capture& capture) {
  if (capture.photometry) return {capture.image, *capture.photometry};
  return LinearReader(capture.image, capture.exposure.black_level, capture.exposure.white_balance.data());
}

const char* photometric_knowledge(const Capture& capture) {
  if (!capture.photometry) return "not measured";
  return capture.photometry->vignette.none() ? "response measured, vignette not" : "response and vignette measured";
}

ImageF linear_radiance(const Capture& capture) {
  ImageF rgb(capture.image.width, capture.image.height, 3);
  linear_reader(capture).read({0, 0, rgb.width(), rgb.height()}, 3, rgb.data(), 3 * std::size_t(rgb.width()));
  return rgb;
}

}  // namespace sheen
