// SPDX-License-Identifier: Apache-2.0
#include "tracker/calibration/registration_overlay.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "common/registration/outline_evidence.h"

namespace sheen {
namespace {

using Colour = std::array<std::uint8_t, 3>;
constexpr Colour kBefore{230, 60, 50}, kAfter{60, 230, 80}, kPoint{255, 225, 40}, kOutlier{255, 60, 255};
constexpr std::size_t kTiles = 4;
constexpr int kCross_px = 6;

class Canvas {
 public:
  Canvas(int width, int height) : picture_(width, height, 3, 0) {}

  void photograph(const ImageF& grey, int x0, int y0) {
    for (int y = 0; y < grey.height(); ++y)
      for (int x = 0; x < grey.width(); ++x)
        set(x0 + x, y0 + y, [v = static_cast<std::uint8_t>(255 * std::clamp(grey.at(x, y), 0.0f, 1.0f))] {
          return Colour{v, v, v};
        }());
  }
  void dot(const Eigen::Vector2d& at, const Colour& colour) {
    const int x = static_cast<int>(std::lround(at.x())), y = static_cast<int>(std::lround(at.y()));
    for (const auto& [dx, dy] : {std::pair{0, 0}, {1, 0}, {0, 1}, {1, 1}}) set(x + dx, y + dy, colour);
  }
  void cross(const Eigen::Vector2d& at, const Colour& colour) {
    for (int i = -kCross_px; i <= kCross_px; ++i) {
      dot(at + Eigen::Vector2d(i, 0), colour);
      dot(at + Eigen::Vector2d(0, i), colour);
    }
  }
  ImageU8 picture() && { return std::move(picture_); }

 private:
  void set(int x, int y, const Colour& colour) {
    if (x < 0 || y < 0 || x >= picture_.width() || y >= picture_.height()) return;
    std::copy(colour.begin(), colour.end(), picture_.pixel(x, y));
  }
  ImageU8 picture_;
};

}  // namespace

ImageU8 registration_overlay(const Mesh& mesh, std::span<const RegistrationImage> images, const Similarity& before,
                             const Similarity& after, std::span<const RegisteredPoint> points) {
  const std::size_t tiles = std::min(kTiles, images.size());
  int width = 0, height = 0;
  for (const RegistrationImage& image : images) {
    width = std::max(width, image.grey.width());
    height = std::max(height, image.grey.height());
  }
  const RayScene scene(mesh);
  const std::vector<EdgeOfMesh> edges = edges_of(mesh);
  Canvas canvas(tiles > 1 ? 2 * width : width, tiles > 2 ? 2 * height : height);
  for (std::size_t tile = 0; tile < tiles; ++tile) {
    const RegistrationImage& image = images[tile * images.size() / tiles];
    const int x0 = static_cast<int>(tile % 2) * width, y0 = static_cast<int>(tile / 2) * height;
    const Eigen::Vector2d corner(x0, y0);
    canvas.photograph(image.grey, x0, y0);
    const auto draw = [&](const Eigen::Vector2d& pixel, bool cross, const Colour& colour) {
      if (!image.view.camera.contains(pixel, 1)) return;  // it would be drawn in the next picture
      cross ? canvas.cross(corner + pixel, colour) : canvas.dot(corner + pixel, colour);
    };
    for (const auto& [place, colour] : {std::pair{before, kBefore}, std::pair{after, kAfter}})
      for (const OutlinePoint& point : outline_of(mesh, edges, scene, in_mesh_frame(image.view, place)))
        draw(point.pixel, false, colour);
    for (const RegisteredPoint& point : points)
      if (const auto pixel = image.view.camera.project(image.view.camera_from_object * point.stage))
        draw(*pixel, true, point.used ? kPoint : kOutlier);
  }
  return std::move(canvas).picture();
}

}  // namespace sheen
