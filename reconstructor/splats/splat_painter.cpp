// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/splats/splat_painter.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace sheen {
namespace {

using Eigen::Matrix2f;
using Eigen::Matrix3f;
using Eigen::Vector2f;
using Eigen::Vector3f;

// What the viewers do.
constexpr float kBlur = 0.3f;  ///< square pixels, added to what a splat covers
constexpr float kMostOpaque = 0.99f;
constexpr float kLeastOpaque = 1.0f / 255;
constexpr float kHidden = 1e-4f;  ///< of a pixel: what lies behind is not looked at
constexpr float kLeastShare = 0.002f;
constexpr float kNearest = 0.01f;    ///< part of the distance to the middle of all splats
constexpr float kBesideView = 1.3f;  ///< tangents are clamped at so many times the image's edge
constexpr int kTile = 16;            ///< pixels

/// A splat in an image.
struct Footprint {
  std::uint32_t splat;
  float depth;
  Vector2f centre;
  Matrix2f inverse;  ///< of its covariance
  float opacity;
  int left, right, top, bottom;  ///< tiles, inclusive
};

struct Pinhole {
  Matrix3f rotation;
  Vector3f translation;
  Vector2f focal, centre;
  int width, height;
};

Pinhole pinhole_of(const PosedCamera& from) {
  const Camera& camera = from.camera;
  return {from.camera_from_object.rotation.toRotationMatrix().cast<float>(),
          from.camera_from_object.translation.cast<float>(),
          Eigen::Vector2d(camera.fx, camera.fy).cast<float>(),
          Eigen::Vector2d(camera.cx, camera.cy).cast<float>(),
          camera.width,
          camera.height};
}

/// Derivative of the projection at a point in camera coordinates.
Eigen::Matrix<float, 2, 3> projection_derivative(const Pinhole& camera, const Vector3f& point) {
  const Vector2f edge = kBesideView * Vector2f(camera.width, camera.height).cwiseQuotient(2 * camera.focal);
  const Vector2f tangent = (point.head<2>() / point.z()).cwiseMax(-edge).cwiseMin(edge);
  Eigen::Matrix<float, 2, 3> derivative;
  derivative << camera.focal.x(), 0, -camera.focal.x() * tangent.x(), 0, camera.focal.y(),
      -camera.focal.y() * tangent.y();
  return derivative / point.z();
}

/// Those that the image shows, from the front.
std::vector<Footprint> footprints(const std::vector<SplatShape>& shapes, const Pinhole& camera, float nearest) {
  std::vector<Footprint> out;
  for (std::uint32_t i = 0; i < shapes.size(); ++i) {
    const SplatShape& shape = shapes[i];
    const Vector3f point = camera.rotation * shape.centre + camera.translation;
    if (point.z() < nearest || shape.opacity < kLeastOpaque) continue;
    const Eigen::Matrix<float, 2, 3> onto = projection_derivative(camera, point) * camera.rotation;
    const Matrix2f covariance = onto * shape.covariance() * onto.transpose() + kBlur * Matrix2f::Identity();
    const Vector2f centre = point.head<2>().cwiseProduct(camera.focal) / point.z() + camera.centre;
    const Vector2f reach = std::sqrt(2 * std::log(shape.opacity / kLeastOpaque)) * covariance.diagonal().cwiseSqrt();
    const auto tile = [](float pixel) { return static_cast<int>(std::floor((pixel + 0.5f) / kTile)); };
    const Vector2f low = centre - reach, high = centre + reach;
    const Footprint footprint{i,
                              point.z(),
                              centre,
                              covariance.inverse(),
                              shape.opacity,
                              std::max(0, tile(low.x())),
                              std::min((camera.width - 1) / kTile, tile(high.x())),
                              std::max(0, tile(low.y())),
                              std::min((camera.height - 1) / kTile, tile(high.y()))};
    if (footprint.left <= footprint.right && footprint.top <= footprint.bottom) out.push_back(footprint);
  }
  std::stable_sort(out.begin(), out.end(), [](const Footprint& a, const Footprint& b) { return a.depth < b.depth; });
  return out;
}

/// What the splats over a pixel's tile show of it, appended.
void look_through(std::span<const Footprint> footprints, const std::vector<std::uint32_t>& over, int x, int y,
                  std::vector<SplatShares::Share>& shares) {
  float left = 1;
  for (const std::uint32_t i : over) {
    const Footprint& footprint = footprints[i];
    const Vector2f off(static_cast<float>(x) - footprint.centre.x(), static_cast<float>(y) - footprint.centre.y());
    const float power = 0.5f * off.dot(footprint.inverse * off);
    const float alpha = std::min(kMostOpaque, footprint.opacity * std::exp(-power));
    if (alpha < kLeastOpaque) continue;
    if (left * alpha > kLeastShare) shares.push_back({footprint.splat, left * alpha});
    left *= 1 - alpha;
    if (left < kHidden) return;
  }
}

}  // namespace

SplatShares splat_shares(const std::vector<SplatShape>& shapes, const PosedCamera& from, const ImageU8& wanted) {
  const Pinhole camera = pinhole_of(from);
  const float nearest = kNearest * camera.translation.norm();
  const std::vector<Footprint> seen = footprints(shapes, camera, nearest);
  const int columns = (camera.width + kTile - 1) / kTile, rows = (camera.height + kTile - 1) / kTile;
  std::vector<std::vector<std::uint32_t>> over(std::size_t(columns) * rows);
  for (std::uint32_t i = 0; i < seen.size(); ++i)
    for (int y = seen[i].top; y <= seen[i].bottom; ++y)
      for (int x = seen[i].left; x <= seen[i].right; ++x) over[std::size_t(y) * columns + x].push_back(i);
  SplatShares out;
  out.first.push_back(0);
  for (int y = 0; y < camera.height; ++y)
    for (int x = 0; x < camera.width; ++x) {
      if (!wanted.empty() && wanted.at(x, y) == 0) continue;
      look_through(seen, over[std::size_t(y / kTile) * columns + x / kTile], x, y, out.shares);
      out.pixels.push_back(static_cast<std::uint32_t>(y * camera.width + x));
      out.first.push_back(out.shares.size());
    }
  return out;
}

Eigen::Matrix3Xf splat_colours(const Splats& splats, const Eigen::Vector3f& eye) {
  Eigen::Matrix3Xf colours(3, Eigen::Index(splats.shapes.size()));
  for (std::size_t i = 0; i < splats.shapes.size(); ++i) {
    const Eigen::VectorXf harmonics = splat_harmonics((splats.shapes[i].centre - eye).normalized(), splats.terms());
    for (int c = 0; c < 3; ++c)
      colours(c, Eigen::Index(i)) = std::max(0.0f, 0.5f + splats.channel(i, c).dot(harmonics));
  }
  return colours;
}

ImageF paint_splats(const Splats& splats, const PosedCamera& from) {
  const Eigen::Matrix3Xf colours = splat_colours(splats, camera_centre(from.camera_from_object).cast<float>());
  const SplatShares shares = splat_shares(splats.shapes, from);
  ImageF picture(from.camera.width, from.camera.height, 4);
  for (std::size_t i = 0; i < shares.pixels.size(); ++i) {
    Eigen::Map<Eigen::Vector4f> pixel(picture.data() + 4 * std::size_t(shares.pixels[i]));
    for (const SplatShares::Share& share : shares.of(i)) {
      pixel.head<3>() += share.weight * colours.col(share.splat);
      pixel[3] += share.weight;
    }
  }
  return picture;
}

}  // namespace sheen
