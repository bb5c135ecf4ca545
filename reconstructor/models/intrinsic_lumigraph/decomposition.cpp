// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/models/intrinsic_lumigraph/decomposition.h"

#include <tbb/parallel_for.h>

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>

#include "common/base/order_statistics.h"
#include "common/parallel/for_each.h"
#include "reconstructor/lumigraph_file/depth_points.h"

namespace sheen {
namespace {

using Eigen::Vector3f;

constexpr float kDark = 1e-4f;         // delta of log(I + delta): far below the step of an 8-bit image
constexpr float kLeastCosine = 0.05f;  // below it a lamp says little of the reflectance
constexpr float kLeastReflectance = 2e-3f;
// Weights of what is known beforehand, and of pixels at the edge of a shadow, against an image's.
constexpr float kHoldNormal = 2e-3f, kHoldAmbient = 1e-2f, kHoldGuessedAmbient = 0.3f, kEdgeWeight = 0.1f;

bool arrives(const CapturedView& view, std::size_t i, std::size_t pixel) {
  return view.arrives[i].data()[pixel] == 255;
}
bool in_shadow(const CapturedView& view, std::size_t i, std::size_t pixel) {
  return view.arrives[i].data()[pixel] == 0;
}

Vector3f rgb_at(const ImageF& image, std::size_t pixel) {
  return Eigen::Map<const Vector3f>(image.data() + 3 * pixel);
}

Eigen::Map<const Eigen::ArrayXf> values_of(const ImageF& image) {
  return {image.data(), static_cast<Eigen::Index>(image.size())};
}

/// The factor by which a colour is that of the reflectance, by least squares over its channels.
float brightness_over(const Vector3f& rgb, const Vector3f& reflectance) {
  return rgb.dot(reflectance) / std::max(reflectance.squaredNorm(), 1e-12f);
}

/// Calls `visit(pixel, point)` for all pixels whose surface is known, in parallel.
void for_each_surface(const CapturedView& view, const std::function<void(std::size_t, const Vector3f&)>& visit) {
  for_each_point(view.from, view.depth, in_parallel, [&](std::size_t pixel, const Vector3f& point) {
    if (view.depth.data()[pixel] > 0) visit(pixel, point);
  });
}

std::vector<Lamp> lamps_of(const CapturedView& view, const LightSet& lights) {
  std::vector<Lamp> lamps;
  for (const int light : view.lights) lamps.push_back(lights.lamp(light));
  return lamps;
}

}  // namespace

double ambient_light(const CapturedView& view, const LightSet& lights) {
  const std::vector<Lamp> lamps = lamps_of(view, lights);
  const DepthPoints points(view.from);
  std::vector<float> found, shadowed;
  constexpr int kStride = 2;  // enough pixels for a median
  for (int y = 0; y < view.depth.height(); y += kStride)
    for (int x = 0; x < view.depth.width(); x += kStride) {
      if (!(view.depth.at(x, y) > 0)) continue;
      const std::size_t pixel = std::size_t(y) * view.depth.width() + x;
      const Vector3f point = points.at(x, y, view.depth.at(x, y)), normal = rgb_at(view.normals, pixel);
      shadowed.clear();
      for (std::size_t i = 0; i < view.lights.size(); ++i)
        if (in_shadow(view, i, pixel)) shadowed.push_back(rgb_at(view.radiance[i], pixel).sum());
      if (shadowed.empty()) continue;
      const float dark = median(shadowed);
      std::vector<float> ratios;  // shadow is R a and light R (a + n.s)
      for (std::size_t i = 0; i < view.lights.size(); ++i) {
        if (!arrives(view, i, pixel)) continue;
        const float cosine = normal.dot(lamps[i].incidence(point));
        const float more = rgb_at(view.radiance[i], pixel).sum() - dark;
        if (cosine > 4 * kLeastCosine && more > 0) ratios.push_back(dark * cosine / more);
      }
      if (!ratios.empty()) found.push_back(median(ratios));
    }
  return found.empty() ? 0 : median(found);
}

double ambient_light(const CapturedView& view, const ImageF& reflectance) {
  std::vector<float> found;
  for (std::size_t pixel = 0; pixel < view.depth.size(); ++pixel)
    for (std::size_t i = 0; i < view.lights.size(); ++i)
      if (in_shadow(view, i, pixel))
        found.push_back(brightness_over(rgb_at(view.radiance[i], pixel), rgb_at(reflectance, pixel)));
  return found.empty() ? 0 : median(found);
}

ImageF known_reflectance(const CapturedView& view, const LightSet& lights, double ambient) {
  const std::vector<Lamp> lamps = lamps_of(view, lights);
  ImageF reflectance(view.depth.width(), view.depth.height(), 3);
  for_each_surface(view, [&](std::size_t pixel, const Vector3f& point) {
    const Vector3f normal = rgb_at(view.normals, pixel);
    thread_local std::array<std::vector<float>, 3> ratios;  // the median of logarithms is that of what they are of
    for (std::vector<float>& of_channel : ratios) of_channel.clear();
    for (const bool in_light : {true, false}) {
      for (std::size_t i = 0; i < view.lights.size(); ++i) {
        if (in_light ? !arrives(view, i, pixel) : !in_shadow(view, i, pixel)) continue;
        const float cosine = in_light ? normal.dot(lamps[i].incidence(point)) : 0;
        if (in_light && cosine < kLeastCosine) continue;
        const float light = static_cast<float>(ambient) + cosine + kDark;
        for (int c = 0; c < 3; ++c) ratios[c].push_back((view.radiance[i].data()[3 * pixel + c] + kDark) / light);
      }
      if (!ratios[0].empty()) break;
    }
    for (int c = 0; c < 3; ++c)
      reflectance.data()[3 * pixel + c] =
          ratios[c].empty() ? kLeastReflectance : std::max(kLeastReflectance, median(ratios[c]));
  });
  return reflectance;
}

IntrinsicView decompose(const CapturedView& view, const LightSet& lights, const ImageF& reflectance, double ambient) {
  const std::vector<Lamp> lamps = lamps_of(view, lights);
  const int w = view.from.camera.width, h = view.from.camera.height;
  IntrinsicView out{.from = view.from,
                    .depth = view.depth,
                    .reflectance = ImageHalf(w, h, 3),
                    .slope = ImageHalf(w, h, 3),
                    .ambient = ImageHalf(w, h, 1),
                    .lights = view.lights,
                    .arrives = view.arrives};
  std::vector<ImageF> unexplained(view.lights.size(), ImageF(w, h, 3));
  for_each_surface(view, [&](std::size_t pixel, const Vector3f& point) {
    Eigen::Map<Eigen::Matrix<Eigen::half, 3, 1>> stored(out.reflectance.data() + 3 * pixel);
    stored = rgb_at(reflectance, pixel).cast<Eigen::half>();
    const Vector3f albedo = stored.cast<float>();
    // L_i = ambient + V_i b.s_i: four unknowns, held near what the neighbourhood says.
    const float hold_ambient = view.normals.empty() ? kHoldGuessedAmbient : kHoldAmbient;
    Eigen::Matrix4f squares = Eigen::Vector4f(hold_ambient, kHoldNormal, kHoldNormal, kHoldNormal).asDiagonal();
    Eigen::Vector4f sums = Eigen::Vector4f::Zero();
    sums[0] = hold_ambient * static_cast<float>(ambient);
    if (!view.normals.empty()) sums.tail<3>() = kHoldNormal * rgb_at(view.normals, pixel);
    for (std::size_t i = 0; i < view.lights.size(); ++i) {
      const float part = static_cast<float>(view.arrives[i].data()[pixel]) / 255;
      const float weight = part == 0 || part == 1 ? 1 : kEdgeWeight;
      const Vector3f s = lamps[i].incidence(point);
      const Eigen::Vector4f row(1, part * s.x(), part * s.y(), part * s.z());
      squares += weight * row * row.transpose();
      sums += weight * brightness_over(rgb_at(view.radiance[i], pixel), albedo) * row;
    }
    const Eigen::Vector4f terms = squares.ldlt().solve(sums);
    const Eigen::half dark = Eigen::half(std::max(0.0f, terms[0]));
    out.ambient.data()[pixel] = dark;
    Eigen::Map<Eigen::Matrix<Eigen::half, 3, 1>> slope(out.slope.data() + 3 * pixel);
    slope = terms.tail<3>().cast<Eigen::half>();

    for (std::size_t i = 0; i < view.lights.size(); ++i) {
      if (!arrives(view, i, pixel)) continue;
      const Vector3f s = lamps[i].incidence(point);
      const float light = static_cast<float>(dark) + std::max(0.0f, slope.cast<float>().dot(s));
      Eigen::Map<Vector3f>(unexplained[i].data() + 3 * pixel) = rgb_at(view.radiance[i], pixel) - light * albedo;
    }
  });

  float largest = 0;
  for (const ImageF& image : unexplained) largest = std::max(largest, values_of(image).abs().maxCoeff());
  out.residual_unit = largest / (127.0f * 127.0f);
  out.residual.resize(unexplained.size());
  tbb::parallel_for(std::size_t{0}, unexplained.size(), [&](std::size_t i) {
    out.residual[i] = ImageS8(w, h, 3);
    if (!(largest > 0)) return;
    const auto values = values_of(unexplained[i]);
    const Eigen::ArrayXf roots = (values.abs() / out.residual_unit).sqrt().round();
    Eigen::Map<Eigen::Array<std::int8_t, Eigen::Dynamic, 1>>(out.residual[i].data(), roots.size()) =
        (values < 0).select(-roots, roots).cast<std::int8_t>();
  });
  return out;
}

}  // namespace sheen
