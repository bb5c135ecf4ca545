// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <vector>

#include "common/geometry/mesh.h"
#include "reconstructor/lumigraph_file/lumigraph_data.h"
#include "reconstructor/models/intrinsic_lumigraph/captured_view.h"

namespace sheen {

/// The rectangle that stands for a surface which only the images know: it faces the camera, goes through the object's
/// origin (or is a metre away where that is not before the camera), and is large enough for the cameras beside it.
/// Throws ConfigError for a lens with distortion.
Mesh view_plane(const PosedCamera& camera);
/// Whether a mesh can only be such a rectangle.
bool is_view_plane(const Mesh& mesh);

/// Depth of a view from its neighbours' images in the same lights (001 sec. 4.2), the costs of all lights added before
/// the best plane is chosen: a light in which a place is dark or flat has no say there. Between 0.6 and 1.7 times the
/// distance of the object's origin.
ImageF swept_depth(std::span<const CapturedView> views, std::size_t view);

/// The same in one light, with the confidence of 001 eq. 1. `light`: of the light set; the view must have it.
struct DepthInLight {
  ImageF depth, confidence;
};
DepthInLight swept_depth_in_light(std::span<const CapturedView> views, std::size_t view, int light);

/// A lumigraph of images alone: depth by stereo, reflectance and shadows by intrinsic images, what hides the lamps by
/// the shadows of all lights together. `views`: cameras, lights and radiance.
LumigraphData lumigraph_of_images(std::vector<CapturedView> views, const LightSet& lights);

}  // namespace sheen
