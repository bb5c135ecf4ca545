// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "common/capture/lighting.h"

namespace sheen {

/// Two lights that images were taken in with none between them.
struct LightInterval {
  LightState from, to;
  double length = 0;    ///< metres between lamps, radians between far lights
  double error = 0;     ///< predicted half way: 99 % of the pixels are off by less, in grey levels as shown
  double required = 0;  ///< the length that the tolerance asks for
  bool too_wide() const { return length > required; }
};

/// How well lights that move cover a scene, and where the next one is worth most.
struct LightAdvice {
  std::vector<LightInterval> intervals;  ///< the worst first: by length over required length
  LightState next;                       ///< in the middle of the worst
};

}  // namespace sheen
