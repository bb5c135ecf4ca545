// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>

#include "common/capture/capture.h"
#include "common/geometry/mesh.h"
#include "reconstructor/models/model_snapshot.h"
#include "reconstructor/render/gl/orbit_camera.h"
#include "reconstructor/render/ray_painter.h"

namespace sheen {

// The small pictures of the monitor page, as JPEG.

/// The camera's image, with the outline of the painter's mesh where there is one and a pose: a person sees at once
/// whether it sits. `painter` may be null.
std::shared_ptr<const std::string> camera_preview(const Capture& capture, const RayPainter* painter);

/// The part of a capture's view that shows the mesh, with a rim round it; without a capture (null), from where a person
/// would look at the mesh.
Viewpoint preview_viewpoint(const Capture* capture, const std::shared_ptr<const Mesh>& mesh);

/// The model; before it has an image, its mesh in grey. The painter is of its mesh.
std::shared_ptr<const std::string> model_preview(const ModelSnapshot& model, const RayPainter& painter,
                                                 const Viewpoint& from);

/// A found shape in the colours of `evidence_color`; null of a mesh without evidence.
std::shared_ptr<const std::string> shape_preview(const Mesh& mesh, const RayPainter& painter, const Viewpoint& from);

}  // namespace sheen
