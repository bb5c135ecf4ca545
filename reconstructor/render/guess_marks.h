// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

#include "common/geometry/mesh.h"
#include "common/image/image.h"
#include "reconstructor/surface/sample_state.h"

namespace sheen {

struct PaintedView;

// Colours of pictures and legends: 0..1, sRGB-encoded.

/// Tint of what is not measured.
Eigen::Vector3f state_color(SampleState state);

/// Of what a found shape is known from; told apart by colour-blind people too.
Eigen::Vector3f evidence_color(ShapeEvidence evidence);

/// Marks what no photograph shows in an 8-bit picture of the view, of 3 channels or more: guesses are striped, imputed
/// parts tinted, as the window does.
void mark_guesses(const PaintedView& view, ImageU8& picture);

}  // namespace sheen
