// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace sheen {

/// Metres: no coordinate of a camera, a light or a vertex is farther from zero, wherever it comes from. Photographs
/// without a scale may be far from 1; products of four such lengths still fit single precision.
inline constexpr double kLongestLength = 1e9;

}  // namespace sheen
