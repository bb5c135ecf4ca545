// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>

namespace sheen {

/// One scalar exposure gain of an image from many surfaces: each gives the log of (radiance seen / radiance expected).
/// The median is what most surfaces agree on, so a highlight that moved cannot pull it; the prior towards 1 is weak and
/// only decides when few surfaces speak or they disagree. Returns the gain by which the image is brighter than
/// expected. NaN entries are left out; the span is overwritten.
float robust_gain(std::span<float> log_ratios);

}  // namespace sheen
