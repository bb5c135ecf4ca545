// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/models/intrinsic_lumigraph/image_geometry.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "common/base/errors.h"
#include "common/image/color.h"
#include "reconstructor/models/intrinsic_lumigraph/carved_hull.h"
#include "reconstructor/models/intrinsic_lumigraph/decomposition.h"
#include "reconstructor/models/intrinsic_lumigraph/plane_sweep.h"
#include "reconstructor/models/intrinsic_lumigraph/shadow_masks.h"
#include "reconstructor/models/intrinsic_lumigraph/weiss.h"

namespace sheen {
namespace {

constexpr double kNearest = 0.6, kFarthest = 1.7;  // of the distance of the object's origin
constexpr std::size_t kMostHullViews = 9;
constexpr double kGuessedAmbient = 0.1;  // where no image shows shadow

double distance_of_object(const PosedCamera& camera) {
  const double z = camera.camera_from_object.translation.z();
  return z > 0 ? z : 1;
}

ImageF encoded_brightness(const ImageF& radiance) {
  ImageF grey(radiance.width(), radiance.height(), 1);
  for (std::size_t i = 0; i < grey.size(); ++i) grey.data()[i] = luminance(radiance.data() + 3 * i);
  srgb_encode_fast({grey.data(), grey.size()});
  return grey;
}

std::vector<PosedCamera> cameras_of(std::span<const CapturedView> views) {
  std::vector<PosedCamera> cameras;
  for (const CapturedView& view : views) cameras.push_back(view.from);
  return cameras;
}

const ImageF* radiance_in(const CapturedView& view, int light) {
  const auto found = std::find(view.lights.begin(), view.lights.end(), light);
  return found == view.lights.end() ? nullptr : &view.radiance[static_cast<std::size_t>(found - view.lights.begin())];
}

/// A view and its neighbours in one light, as eyes see them.
struct ImagesInLight {
  std::vector<ImageF> greys;  ///< what the others point to
  SweepImage view;
  std::vector<SweepImage> others;
};
/// None where no neighbour has the light.
std::optional<ImagesInLight> images_in_light(std::span<const CapturedView> views, std::size_t view,
                                             std::span<const std::size_t> neighbours, int light) {
  ImagesInLight images;
  images.greys.reserve(neighbours.size() + 1);
  const auto image_of = [&](std::size_t v) {
    const ImageF* radiance = radiance_in(views[v], light);
    if (radiance) images.greys.push_back(encoded_brightness(*radiance));
    return SweepImage{views[v].from, radiance ? &images.greys.back() : nullptr};
  };
  images.view = image_of(view);
  for (const std::size_t n : neighbours)
    if (const SweepImage image = image_of(n); image.grey) images.others.push_back(image);
  if (!images.view.grey || images.others.empty()) return std::nullopt;
  return images;
}

/// A view's sweep: its neighbours, whichever lights they have, and the planes.
struct Sweep {
  std::vector<std::size_t> neighbours;
  std::vector<double> planes;

  Sweep(std::span<const CapturedView> views, std::size_t view) {
    const std::vector<PosedCamera> cameras = cameras_of(views);
    neighbours = spread_neighbours(cameras, view);
    std::vector<SweepImage> beside;
    for (const std::size_t n : neighbours) beside.push_back({cameras[n], nullptr});
    const double z = distance_of_object(cameras[view]);
    planes = sweep_planes(cameras[view], beside, kNearest * z, kFarthest * z);
  }
};

ImageF flat_depth(const CapturedView& view) {
  return ImageF(view.from.camera.width, view.from.camera.height, 1, static_cast<float>(distance_of_object(view.from)));
}

/// Some of the views, evenly taken.
std::vector<const IntrinsicView*> some_views(const LumigraphData& data) {
  std::vector<const IntrinsicView*> some;
  const std::size_t n = data.views.size(), count = std::min(n, kMostHullViews);
  for (std::size_t k = 0; k < count; ++k) some.push_back(data.views[(2 * k + 1) * n / (2 * count)].get());
  return some;
}

}  // namespace

Mesh view_plane(const PosedCamera& camera) {
  if (!camera.camera.is_pinhole())
    throw ConfigError(
        "an intrinsic lumigraph without a mesh needs images without lens distortion; undistort them, or "
        "give --mesh");
  const double depth = distance_of_object(camera);
  const Rigid3 object_from_camera = camera.camera_from_object.inverse();
  const double w = camera.camera.width, h = camera.camera.height;
  std::vector<Eigen::Vector3d> corners;
  for (const auto& [x, y] : {std::pair{-w, -h}, {2 * w, -h}, {2 * w, 2 * h}, {-w, 2 * h}})
    corners.push_back(object_from_camera * (depth * Eigen::Vector3d((x - camera.camera.cx) / camera.camera.fx,
                                                                    (y - camera.camera.cy) / camera.camera.fy, 1)));
  return mesh_of(corners, {{0, 3, 2}, {0, 2, 1}});
}

bool is_view_plane(const Mesh& mesh) {
  return mesh.vertices.size() == 4 && mesh.triangles.size() == 2 && mesh.triangles[0] == Triangle{0, 3, 2} &&
         mesh.triangles[1] == Triangle{0, 2, 1};
}

ImageF swept_depth(std::span<const CapturedView> views, std::size_t view) {
  const Sweep sweep(views, view);
  std::optional<SweepCosts> sum;
  for (const int light : views[view].lights) {
    const auto images = images_in_light(views, view, sweep.neighbours, light);
    if (!images) continue;
    SweepCosts costs(images->view, images->others, sweep.planes);
    if (sum)
      *sum += costs;
    else
      sum = std::move(costs);
  }
  if (!sum) return flat_depth(views[view]);
  RefinedDepth refined(sweep.planes, sum->best_planes());
  sum.reset();
  for (const int light : views[view].lights)
    if (const auto images = images_in_light(views, view, sweep.neighbours, light))
      refined.add(images->view, images->others);
  return smoothed_depth(refined.depth());
}

DepthInLight swept_depth_in_light(std::span<const CapturedView> views, std::size_t view, int light) {
  const Sweep sweep(views, view);
  const auto images = images_in_light(views, view, sweep.neighbours, light);
  const Camera& camera = views[view].from.camera;
  if (!images) return {flat_depth(views[view]), ImageF(camera.width, camera.height, 1)};
  const SweepCosts costs(images->view, images->others, sweep.planes);
  return {costs.depth(), costs.confidence()};
}

LumigraphData lumigraph_of_images(std::vector<CapturedView> views, const LightSet& lights) {
  LumigraphData data{.lights = lights, .of_images = true};
  std::vector<ImageF> depths;
  for (std::size_t v = 0; v < views.size(); ++v) depths.push_back(swept_depth(views, v));
  for (std::size_t v = 0; v < views.size(); ++v) {
    CapturedView& view = views[v];
    view.depth = std::move(depths[v]);
    const ImageF reflectance = estimate_reflectance(view.radiance);
    view.arrives = shadow_masks(view, lights);
    const double ambient = ambient_light(view, reflectance);
    data.views.push_back(std::make_shared<const IntrinsicView>(
        decompose(view, lights, reflectance, ambient > 0 ? ambient : kGuessedAmbient)));
    view = {.from = view.from};  // its images are no longer needed
  }
  data.hull = carved_hull(some_views(data), lights);
  return data;
}

}  // namespace sheen
