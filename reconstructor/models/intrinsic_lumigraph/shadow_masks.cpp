// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/models/intrinsic_lumigraph/shadow_masks.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "common/base/order_statistics.h"
#include "common/parallel/for_each.h"
#include "reconstructor/lumigraph_file/depth_points.h"
#include "reconstructor/models/intrinsic_lumigraph/weiss.h"

namespace sheen {
namespace {

using Eigen::Vector3f;

constexpr int kRounds = 4;
constexpr float kStillLit = 0.65f;    // of what the fitted surface would show: below it a light is taken for shadowed
constexpr float kRidge = 1e-2f;       // against the squares of the incidences
constexpr float kLeastCosine = 0.3f;  // a lamp further down is as if shadowed: its light is that of a dim pixel
constexpr float kDark = 1e-3f;
constexpr double kFirstStep = 9, kLeastRise = 0.15;  // pixels along the way to a lamp; of that, before the surface

/// The normal times the albedo of a matt surface under those lights that it explains.
Vector3f matt_surface(const std::vector<Vector3f>& incidences, const std::vector<float>& brightness) {
  const float middle = median(std::vector<float>(brightness));
  std::vector<bool> lit(brightness.size());
  for (std::size_t i = 0; i < brightness.size(); ++i) lit[i] = brightness[i] >= kStillLit * middle;
  Vector3f surface = Vector3f::Zero();
  for (int round = 0; round < kRounds; ++round) {
    Eigen::Matrix3f squares = kRidge * Eigen::Matrix3f::Identity();
    Vector3f sums = Vector3f::Zero();
    for (std::size_t i = 0; i < brightness.size(); ++i)
      if (lit[i]) {
        squares += incidences[i] * incidences[i].transpose();
        sums += brightness[i] * incidences[i];
      }
    surface = squares.ldlt().solve(sums);
    for (std::size_t i = 0; i < brightness.size(); ++i)
      lit[i] = brightness[i] >= kStillLit * surface.dot(incidences[i]);
  }
  return surface;
}

/// Whether a way to a lamp begins before the surface that the camera sees. Behind it the surface faces away: that a
/// pixel is in shadow in all lights cannot be told by its brightness.
bool rises_before_surface(const CapturedView& view, const Vector3f& point, const Vector3f& towards) {
  const double z = (view.from.camera_from_object * point.cast<double>()).z();
  const double step = kFirstStep * z / view.from.camera.fx;
  const Eigen::Vector3d at =
      view.from.camera_from_object * (point.cast<double>() + step * towards.normalized().cast<double>());
  const auto pixel = view.from.camera.project(at);
  if (!pixel || !view.from.camera.contains(*pixel)) return true;
  const float seen =
      view.depth.at(static_cast<int>(std::lround(pixel->x())), static_cast<int>(std::lround(pixel->y())));
  return seen - at.z() > kLeastRise * step;
}

/// `parts`: of the light that arrives, from the brightness of a pixel; taken next to the other class.
ImageU8 with_parts_at_edges(const ImageU8& classes, const ImageF& parts) {
  const int w = classes.width(), h = classes.height();
  const cv::Mat mask(h, w, CV_8UC1, const_cast<std::uint8_t*>(classes.data())), square = cv::Mat::ones(3, 3, CV_8U);
  cv::Mat least, most;
  cv::erode(mask, least, square, {-1, -1}, 1, cv::BORDER_REPLICATE);
  cv::dilate(mask, most, square, {-1, -1}, 1, cv::BORDER_REPLICATE);
  ImageU8 out(w, h, 1);
  for (int y = 0; y < h; ++y)
    for (int x = 0; x < w; ++x)
      out.at(x, y) = least.at<std::uint8_t>(y, x) == most.at<std::uint8_t>(y, x)
                         ? classes.at(x, y)
                         : static_cast<std::uint8_t>(std::clamp(std::lround(255 * parts.at(x, y)), 1l, 254l));
  return out;
}

/// Of what a matt surface would show: the median of what is darker than the threshold.
float brightness_in_shadow(const ImageF& darker, const ImageU8& facing, float threshold) {
  std::vector<float> shadowed;
  for (std::size_t i = 0; i < darker.size(); ++i)
    if (facing.data()[i] != 0 && darker.data()[i] <= threshold) shadowed.push_back(darker.data()[i]);
  return shadowed.empty() ? 0 : std::exp(median(shadowed));
}

}  // namespace

std::vector<ImageU8> shadow_masks(const CapturedView& view, const LightSet& lights) {
  const std::size_t n = view.lights.size();
  const int w = view.depth.width(), h = view.depth.height();
  std::vector<Lamp> lamps;
  for (const int light : view.lights) lamps.push_back(lights.lamp(light));
  ImageF darker(w, h, static_cast<int>(n));  // log of brightness over what a matt surface would show
  ImageU8 facing(w, h, static_cast<int>(n));
  for_each_point(view.from, view.depth, in_parallel, [&](std::size_t pixel, const Vector3f& point) {
    std::vector<Vector3f> incidences(n);
    std::vector<float> brightness(n);
    for (std::size_t i = 0; i < n; ++i) {
      incidences[i] = lamps[i].incidence(point);
      const float* rgb = view.radiance[i].data() + 3 * pixel;
      brightness[i] = rgb[0] + rgb[1] + rgb[2];
    }
    const Vector3f surface = matt_surface(incidences, brightness);
    for (std::size_t i = 0; i < n; ++i) {
      const float expected = std::max(surface.dot(incidences[i]), kLeastCosine * surface.norm() * incidences[i].norm());
      facing.data()[n * pixel + i] = rises_before_surface(view, point, lamps[i].towards(point));
      darker.data()[n * pixel + i] = std::clamp(std::log((brightness[i] + kDark) / (expected + kDark)), -3.0f, 1.0f);
    }
  });
  const float threshold = otsu_threshold(darker, facing);
  const float dark = brightness_in_shadow(darker, facing, threshold);
  std::vector<ImageU8> masks;
  for (std::size_t i = 0; i < n; ++i) {
    ImageU8 classes(w, h, 1);
    ImageF parts(w, h, 1);
    for (std::size_t pixel = 0; pixel < classes.size(); ++pixel) {
      const bool faces = facing.data()[n * pixel + i] != 0;
      classes.data()[pixel] = faces && darker.data()[n * pixel + i] > threshold ? 255 : 0;
      if (faces) parts.data()[pixel] = (std::exp(darker.data()[n * pixel + i]) - dark) / (1 - dark);
    }
    masks.push_back(with_parts_at_edges(classes, parts));
  }
  return masks;
}

}  // namespace sheen
