// SPDX-License-Identifier: Apache-2.0
#include "common/registration/silhouette.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <opencv2/imgproc.hpp>

namespace sheen {

ImageU8 SilhouetteCaster::cast(const PosedCamera& view, const Mesh& mesh, const RayScene& scene) {
  const Camera& camera = view.camera;
  const auto width = static_cast<std::size_t>(camera.width);
  if (!(rays_of_ == camera)) {
    rays_of_ = camera;
    rays_.resize(width * static_cast<std::size_t>(camera.height));
    tbb::parallel_for(0, camera.height, [&](int y) {
      for (int x = 0; x < camera.width; ++x) {
        const auto ray = camera.ray({double(x), double(y)});
        rays_[y * width + x] = ray ? Eigen::Vector3f(ray->cast<float>())
                                   : Eigen::Vector3f::Constant(std::numeric_limits<float>::quiet_NaN());
      }
    });
  }
  // Rows and columns that the mesh can fall on; all of them where a vertex cannot be seen at all.
  PixelBox box{camera.width, camera.height, 0, 0};
  for (const Eigen::Vector3f& vertex : mesh.vertices) {
    const auto pixel = camera.project(view.camera_from_object * vertex.cast<double>());
    if (!pixel) {
      box = {0, 0, camera.width, camera.height};
      break;
    }
    box.x0 = std::clamp(static_cast<int>(std::floor(pixel->x())), 0, box.x0);
    box.y0 = std::clamp(static_cast<int>(std::floor(pixel->y())), 0, box.y0);
    box.x1 = std::clamp(static_cast<int>(std::ceil(pixel->x())) + 1, box.x1, camera.width);
    box.y1 = std::clamp(static_cast<int>(std::ceil(pixel->y())) + 1, box.y1, camera.height);
  }
  ImageU8 silhouette(camera.width, camera.height, 1, 0);
  const Eigen::Vector3f eye = camera_centre(view.camera_from_object).cast<float>();
  const Eigen::Matrix3f object_from_camera =
      view.camera_from_object.rotation.conjugate().toRotationMatrix().cast<float>();
  tbb::parallel_for(box.y0, std::max(box.y1, box.y0), [&](int y) {
    for (int x = box.x0; x < box.x1; ++x) {
      const Eigen::Vector3f& ray = rays_[y * width + x];
      if (!ray.allFinite()) continue;
      const Hit hit = scene.intersect(Ray{eye, object_from_camera * ray});
      if (hit && hit.front) silhouette.at(x, y) = 255;
    }
  });
  return silhouette;
}

ImageF distance_from_outline(const ImageU8& silhouette) {
  const cv::Mat inside(silhouette.height(), silhouette.width(), CV_8U, const_cast<std::uint8_t*>(silhouette.data()));
  cv::Mat from_outside, from_inside;
  cv::distanceTransform(inside, from_outside, cv::DIST_L2, cv::DIST_MASK_5);
  cv::distanceTransform(inside == 0, from_inside, cv::DIST_L2, cv::DIST_MASK_5);
  ImageF distance(silhouette.width(), silhouette.height(), 1);
  for (int y = 0; y < distance.height(); ++y)
    for (int x = 0; x < distance.width(); ++x)
      distance.at(x, y) =
          silhouette.at(x, y) != 0 ? from_outside.at<float>(y, x) - 0.5f : 0.5f - from_inside.at<float>(y, x);
  return distance;
}

}  // namespace sheen
