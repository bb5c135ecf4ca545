// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "common/capture/lighting.h"

namespace sheen {

/// Empty, or why a light cannot be one of a set of lights of this kind: a short, stable word.
std::string light_refusal(const LightState& light, LightKind kind);

}  // namespace sheen
