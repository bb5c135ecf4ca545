// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/shape/shape_view.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "common/capture/linear_capture.h"
#include "common/image/color.h"
#include "common/parallel/for_each.h"
#include "reconstructor/radiance/radiance_image.h"

namespace sheen {

Camera camera_of_part(const Camera& camera, const PixelBox& part, double scale) {
  Camera of_part = camera;
  of_part.lens = LensModel::kOpenCv;
  of_part.distortion = {};
  of_part.width = std::max(1, static_cast<int>(std::lround(part.width() * scale)));
  of_part.height = std::max(1, static_cast<int>(std::lround(part.height() * scale)));
  of_part.fx *= scale;
  of_part.fy *= scale;
  of_part.cx = (camera.cx + 0.5 - part.x0) * scale - 0.5;  // integer pixels are centres
  of_part.cy = (camera.cy + 0.5 - part.y0) * scale - 0.5;
  return of_part;
}

ColourView colour_view(const Capture& capture, const PixelBox& part, double scale) {
  const Camera camera = camera_of_part(capture.camera, part, scale);
  ShapeView view{.name = capture.name,
                 .camera = {camera, capture.pose.camera_from_object},
                 .grey = ImageF(camera.width, camera.height, 1, std::numeric_limits<float>::quiet_NaN()),
                 .outline = {}};
  ImageF colour(camera.width, camera.height, 3, std::numeric_limits<float>::quiet_NaN());
  if (!capture.mask.empty())
    view.outline = ImageU8(camera.width, camera.height, 1, static_cast<std::uint8_t>(Outline::kUnknown));
  const RadianceImage image(linear_radiance(capture));
  const auto step = static_cast<float>(1 / scale);
  in_parallel(camera.height, [&](std::size_t row) {
    const int y = static_cast<int>(row);
    for (int x = 0; x < camera.width; ++x) {
      const auto from = capture.camera.project({(x - camera.cx) / camera.fx, (y - camera.cy) / camera.fy, 1});
      if (!from || !capture.camera.contains(*from)) continue;
      const Eigen::Vector3f rgb = image.sample(from->cast<float>(), step);
      Eigen::Map<Eigen::Vector3f>(colour.pixel(x, y)) = rgb;
      const float grey = 255 * srgb_encode_fast(std::clamp(luminance(rgb.data()), 0.0f, 1.0f));
      if (std::isfinite(grey)) view.grey.at(x, y) = grey;
      if (view.outline.empty()) continue;
      const bool object =
          capture.mask.at(static_cast<int>(std::lround(from->x())), static_cast<int>(std::lround(from->y()))) != 0;
      view.outline.at(x, y) = static_cast<std::uint8_t>(object ? Outline::kObject : Outline::kBackground);
    }
  });
  return {std::move(view), std::move(colour)};
}

}  // namespace sheen
