// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cmath>
#include <cstdint>

#include "common/capture/capture.h"

namespace sheen {

/// Whether a capture judges the model instead of feeding it; `every` Nth does where captures do not say so themselves,
/// 0 = none. Its own number decides, not what became of the images before it: should one of these be withdrawn, all
/// others keep their part.
inline bool is_held_out(const Capture& capture, int every) {
  if (capture.purpose != Purpose::kUnspecified) return capture.purpose == Purpose::kHeldOut;
  return every > 0 && capture.sequence > 0 && capture.sequence % static_cast<std::uint64_t>(every) == 0;
}

/// Exposure time times gain, in arbitrary units; 0 when unknown or when grey levels are not proportional to light.
inline double exposure_product(const Capture& capture) {
  const bool linear = capture.photometry || capture.image.transfer == Transfer::kLinear;
  const bool known = capture.exposure.exposure_s > 0 && linear;
  return known ? capture.exposure.exposure_s * std::pow(10.0, capture.exposure.gain_db / 20) : 0;
}

}  // namespace sheen
