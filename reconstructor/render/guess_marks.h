// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "common/image/image.h"
#include "reconstructor/surface/sample_state.h"

namespace sheen {

struct PaintedView;

/// Tint of what is not measured, in pictures and legends: 0..1, sRGB-encoded.
Eigen::Vector3f state_color(SampleState state);

/// Marks what no photograph shows in an 8-bit picture of the view, of 3 channels or more: guesses are striped, imputed
/// parts tinted, as the window does.
void mark_guesses(const PaintedView& view, ImageU8& picture);

}  // namespace sheen
