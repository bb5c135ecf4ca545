// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/render/ray_painter.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>

#include "common/image/color.h"

namespace sheen {
namespace {

std::uint8_t coverage_of(SampleState state) {
  switch (state) {
    case SampleState::kUnseen:
      return kCoverageUnseen;
    case SampleState::kImputed:
      return kCoverageImputed;
    case SampleState::kMeasured:
      break;
  }
  return kCoverageMeasured;
}

constexpr std::size_t kRaysPerOutlinePixel = 16;

/// Places in a pixel's square, from its centre (Hammersley's points): every sixteenth of the width and of the height
/// has one, so that outlines of all directions are met in many steps.
std::array<Eigen::Vector2d, kRaysPerOutlinePixel> places_in_pixel() {
  std::array<Eigen::Vector2d, kRaysPerOutlinePixel> places;
  for (unsigned i = 0; i < kRaysPerOutlinePixel; ++i) {
    const unsigned reversed = (i & 1) << 3 | (i & 2) << 1 | (i & 4) >> 1 | (i & 8) >> 3;
    places[i] = (Eigen::Vector2d(i, reversed).array() + 0.5) / double(kRaysPerOutlinePixel) - 0.5;
  }
  return places;
}

/// What a ray meets.
SurfaceSample sample_at(const ViewShader& shader, const Hit& hit) {
  return hit.front ? shader.shade(hit.triangle, hit.u, hit.v) : shader.shade_back(hit.triangle, hit.u, hit.v);
}

/// A pixel that the lens cannot reach looks nowhere: an empty interval hits nothing.
Ray ray_of(const Camera& camera, const Rigid3& object_from_camera, const Eigen::Vector2d& pixel) {
  const Eigen::Vector3f eye = object_from_camera.translation.cast<float>();
  const auto ray = camera.ray(pixel);
  return ray ? Ray{eye, (object_from_camera.rotation * *ray).cast<float>()} : Ray{eye, {0, 0, 1}, 0, -1};
}

}  // namespace

ImageF premultiplied(const SmoothView& view) {
  ImageF picture(view.beauty.width(), view.beauty.height(), 4);
  for (std::size_t i = 0; i < view.alpha.size(); ++i) {
    const float alpha = view.alpha.data()[i];
    for (std::size_t c = 0; c < 3; ++c) picture.data()[4 * i + c] = alpha * view.beauty.data()[3 * i + c];
    picture.data()[4 * i + 3] = alpha;
  }
  return picture;
}

ImageU8 straight_srgb8(const SmoothView& view) {
  const ImageU8 colors = to_srgb8(view.beauty);
  ImageU8 picture(view.beauty.width(), view.beauty.height(), 4);
  for (std::size_t i = 0; i < view.alpha.size(); ++i) {
    std::copy_n(colors.data() + 3 * i, 3, picture.data() + 4 * i);
    picture.data()[4 * i + 3] = static_cast<std::uint8_t>(255 * view.alpha.data()[i] + 0.5f);
  }
  return picture;
}

std::vector<Hit> RayPainter::cast(const Camera& camera, const Rigid3& camera_from_object) const {
  const Rigid3 object_from_camera = camera_from_object.inverse();
  std::vector<Hit> hits(std::size_t(camera.width) * camera.height);
  tbb::parallel_for(0, camera.height, [&](int y) {
    cast_row(camera, object_from_camera, y, std::span(hits).subspan(std::size_t(y) * camera.width, camera.width));
  });
  return hits;
}

ImageU8 RayPainter::silhouette(const Camera& camera, const Rigid3& camera_from_object) const {
  const Rigid3 object_from_camera = camera_from_object.inverse();
  ImageU8 picture(camera.width, camera.height, 1);
  tbb::parallel_for(0, camera.height, [&](int y) {
    std::vector<Hit> hits(camera.width);
    cast_row(camera, object_from_camera, y, hits);
    for (int x = 0; x < camera.width; ++x) picture.at(x, y) = hits[x] && hits[x].front ? 255 : 0;
  });
  return picture;
}

void RayPainter::cast_row(const Camera& camera, const Rigid3& object_from_camera, int y, std::span<Hit> hits) const {
  std::vector<Ray> rays(camera.width);
  for (int x = 0; x < camera.width; ++x) rays[x] = ray_of(camera, object_from_camera, {double(x), double(y)});
  scene_->intersect(rays, hits);
}

PaintedView RayPainter::paint(const Appearance& snapshot, const Camera& camera, const Rigid3& camera_from_object,
                              const LightState& light, std::vector<LightState> more_lights) const {
  return paint(*snapshot.shader_for({camera_centre(camera_from_object), light, std::move(more_lights)}), camera,
               camera_from_object);
}

PaintedView RayPainter::paint(const ViewShader& shader, const Camera& camera, const Rigid3& camera_from_object) const {
  const Rigid3 object_from_camera = camera_from_object.inverse();
  const int w = camera.width, h = camera.height;
  PaintedView view{ImageF(w, h, 3), ImageU8(w, h, 1), ImageF(w, h, 1), ImageF(w, h, 1), ImageU8(w, h, 1)};
  tbb::parallel_for(0, h, [&](int y) {
    std::vector<Hit> hits(w);
    cast_row(camera, object_from_camera, y, hits);
    for (int x = 0; x < w; ++x) {
      const Hit& hit = hits[x];
      if (!hit) continue;
      const SurfaceSample sample = sample_at(shader, hit);
      for (int c = 0; c < 3; ++c) view.beauty.at(x, y, c) = sample.rgb[c];
      view.coverage.at(x, y) = coverage_of(sample.state);
      const bool known = hit.front || sample.state != SampleState::kUnseen;
      const SurfaceQuality quality = known ? shader.quality(hit.triangle) : SurfaceQuality{};
      view.predicted_error.at(x, y) = quality.error;
      view.heuristic.at(x, y) = quality.heuristic();
      view.reason.at(x, y) = static_cast<std::uint8_t>(quality.reason()) + 1;
    }
  });
  return view;
}

SmoothView RayPainter::paint_smooth(const Appearance& snapshot, const Outlines& outlines, const Camera& camera,
                                    const Rigid3& camera_from_object, const LightState& light) const {
  static const auto kPlaces = places_in_pixel();
  const std::unique_ptr<ViewShader> shader = snapshot.shader_for({camera_centre(camera_from_object), light});
  SmoothView view{paint(*shader, camera, camera_from_object), ImageF(camera.width, camera.height, 1)};
  const ImageU8 outline = outlines.pixels(camera, camera_from_object);
  const Rigid3 object_from_camera = camera_from_object.inverse();
  tbb::parallel_for(0, camera.height, [&](int y) {
    std::array<Ray, kRaysPerOutlinePixel> rays;
    std::array<Hit, kRaysPerOutlinePixel> hits;
    for (int x = 0; x < camera.width; ++x) {
      if (outline.at(x, y) == 0) {
        view.alpha.at(x, y) = view.coverage.at(x, y) > 0 ? 1 : 0;
        continue;
      }
      for (std::size_t i = 0; i < rays.size(); ++i)
        rays[i] = ray_of(camera, object_from_camera, Eigen::Vector2d(x, y) + kPlaces[i]);
      scene_->intersect(rays, hits);
      Eigen::Vector3f sum = Eigen::Vector3f::Zero();
      int surface = 0;
      for (const Hit& hit : hits) {
        if (!hit) continue;
        sum += sample_at(*shader, hit).rgb;
        ++surface;
      }
      view.alpha.at(x, y) = static_cast<float>(surface) / kRaysPerOutlinePixel;
      if (surface > 0) Eigen::Map<Eigen::Vector3f>(view.beauty.pixel(x, y)) = sum / static_cast<float>(surface);
    }
  });
  return view;
}

}  // namespace sheen
