// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/shape/shape_images.h"

#include <algorithm>
#include <cmath>

#include "common/base/order_statistics.h"
#include "reconstructor/shape/neighbour_views.h"
#include "reconstructor/shape/object_box.h"

namespace sheen {
namespace {

constexpr double kCoarseWidth_px = 320;  // of an image in which the object is looked for

ShapeView marked_view(const Capture& capture, const PixelBox& part, double scale, const PlainBackground& background) {
  ShapeView view = shape_view(capture, part, scale);
  if (view.outline.empty() && background.found) mark_background(background, view);
  return view;
}

/// By where the corners of the stage's tags lie, which a session's captures know.
void extend_by_tags(const Capture& capture, Eigen::AlignedBox2d& stage) {
  const Rigid3 object_from_camera = capture.pose.camera_from_object.inverse();
  for (const TagObservation& tag : capture.tags) {
    if (!tag.used) continue;
    for (const Eigen::Vector2d& corner : tag.corners) {
      const auto ray = capture.camera.ray(corner);
      if (!ray) continue;
      const Eigen::Vector3d eye = object_from_camera.translation, down = object_from_camera.rotation * *ray;
      if (down.z() < 0) stage.extend((eye - eye.z() / down.z() * down).head<2>().eval());
    }
  }
}

}  // namespace

ShapeImages::ShapeImages(const RefinementImages& images, const Eigen::Vector3d& place, std::size_t most)
    : all(images), used(spread_views(images.cameras, place, most)) {
  for (const std::size_t i : used) cameras.push_back(images.cameras[i]);
}

std::vector<ShapeView> coarse_views(ShapeImages& images) {
  std::vector<ShapeView> views;
  for (std::size_t i = 0; i < images.used.size(); ++i) {
    const Capture capture = images.read(i);
    const Camera& camera = capture.camera;
    const PixelBox whole{0, 0, camera.width, camera.height};
    const double scale = std::min(1.0, kCoarseWidth_px / std::max(camera.width, camera.height));
    ShapeView view = shape_view(capture, whole, scale);
    images.backgrounds.push_back(view.outline.empty() ? plain_background(view) : PlainBackground{});
    if (view.outline.empty() && images.backgrounds.back().found) mark_background(images.backgrounds.back(), view);
    views.push_back(std::move(view));
    extend_by_tags(capture, images.stage);
  }
  return views;
}

std::vector<ShapeView> fine_views(const ShapeImages& images, const Eigen::AlignedBox3d& box, double pixels) {
  std::vector<PixelBox> parts;
  std::vector<double> areas;
  for (const PosedCamera& camera : images.cameras) {
    parts.push_back(part_with(box, camera));
    areas.push_back(double(parts.back().width()) * parts.back().height());
  }
  const double scale = std::min(1.0, std::sqrt(pixels / std::max(1.0, median(areas))));
  std::vector<ShapeView> views;
  for (std::size_t i = 0; i < images.used.size(); ++i) {
    if (parts[i].empty()) parts[i] = {0, 0, 1, 1};
    views.push_back(marked_view(images.read(i), parts[i], scale, images.backgrounds[i]));
  }
  return views;
}

}  // namespace sheen
