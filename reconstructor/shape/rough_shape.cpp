// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/shape/rough_shape.h"

#include "common/parallel/for_each.h"
#include "common/registration/silhouette.h"
#include "reconstructor/shape/silhouette.h"

namespace sheen {
namespace {

constexpr double kSlack = 0.03;  // of the diameter of its bounding sphere

}  // namespace

RoughShape::RoughShape(const Mesh& mesh) : scene_(mesh), origin_(mesh.origin) {
  const BoundingSphere sphere = bounding_sphere(mesh);
  middle_ = sphere.centre + origin_;
  slack_ = kSlack * 2 * sphere.radius;
}

void RoughShape::mark_outline(ShapeView& view) const {
  const Camera& camera = view.camera.camera;
  const double depth = (view.camera.camera_from_object * middle_).z();
  if (!view.outline.empty() || !(depth > 0)) return;
  ImageU8 on(camera.width, camera.height, 1);
  const Silhouette silhouette(view, scene_, origin_);
  in_parallel(camera.height, [&](std::size_t row) {
    const int y = static_cast<int>(row);
    for (int x = 0; x < camera.width; ++x) on.at(x, y) = silhouette.has(x, y) ? 255 : 0;
  });
  const auto slack_px = static_cast<float>(slack_ * camera.fx / depth);
  const ImageF inside = distance_from_outline(on);
  view.outline = ImageU8(camera.width, camera.height, 1, static_cast<std::uint8_t>(Outline::kUnknown));
  for (int y = 0; y < camera.height; ++y)
    for (int x = 0; x < camera.width; ++x) {
      if (inside.at(x, y) < -slack_px)
        view.outline.at(x, y) = static_cast<std::uint8_t>(Outline::kBackground);
      else if (inside.at(x, y) > slack_px)
        view.outline.at(x, y) = static_cast<std::uint8_t>(Outline::kObject);
    }
}

}  // namespace sheen
