// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "reconstructor/lumigraph_file/lumigraph_data.h"

namespace sheen {

/// Part of each pixel of a view that a lamp reaches, 0..255, by a hull; edges are smoothed over two pixels.
ImageU8 reached_past(const ShadowHull& hull, const IntrinsicView& view, const Lamp& lamp);

/// Without a mesh: part of each pixel of a view that a light reaches, 0..255. Of a captured light it is the mask of its
/// image; between lights what the hull lets through, but what is in shadow in all of the neighbours stays so.
ImageU8 predicted_arrival(const LumigraphData& data, const IntrinsicView& view, const Eigen::Vector3d& place);

}  // namespace sheen
