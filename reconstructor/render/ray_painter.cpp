// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/render/ray_painter.h"

#include <tbb/parallel_for.h>

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

}  // namespace

std::vector<Hit> RayPainter::cast(const Camera& camera, const Rigid3& camera_from_object) const {
  const Rigid3 object_from_camera = camera_from_object.inverse();
  const Eigen::Vector3f eye = object_from_camera.translation.cast<float>();
  std::vector<Hit> hits(std::size_t(camera.width) * camera.height);
  tbb::parallel_for(0, camera.height, [&](int y) {
    std::vector<Ray> rays(camera.width);
    for (int x = 0; x < camera.width; ++x) {
      const auto ray = camera.ray({double(x), double(y)});
      // A pixel that the lens cannot reach looks nowhere: an empty interval hits nothing.
      rays[x] = ray ? Ray{eye, (object_from_camera.rotation * *ray).cast<float>()} : Ray{eye, {0, 0, 1}, 0, -1};
    }
    scene_.intersect(rays, std::span(hits).subspan(std::size_t(y) * camera.width, camera.width));
  });
  return hits;
}

PaintedView RayPainter::paint(const Appearance& snapshot, const Camera& camera, const Rigid3& camera_from_object,
                              const LightState& light, std::vector<LightState> more_lights) const {
  const std::vector<Hit> hits = cast(camera, camera_from_object);
  const std::unique_ptr<ViewShader> shader =
      snapshot.shader_for({camera_centre(camera_from_object), light, std::move(more_lights)});
  const int w = camera.width, h = camera.height;
  PaintedView view{ImageF(w, h, 3), ImageU8(w, h, 1), ImageF(w, h, 1), ImageF(w, h, 1), ImageU8(w, h, 1)};
  tbb::parallel_for(0, h, [&](int y) {
    for (int x = 0; x < w; ++x) {
      const Hit& hit = hits[std::size_t(y) * w + x];
      if (!hit) continue;
      SurfaceSample sample = shader->shade(hit.triangle, hit.u, hit.v);
      // No image shows the back of a triangle: the colour of its front is the guess.
      if (!hit.front) sample.state = SampleState::kUnseen;
      for (int c = 0; c < 3; ++c) view.beauty.at(x, y, c) = sample.rgb[c];
      view.coverage.at(x, y) = coverage_of(sample.state);
      const SurfaceQuality quality = hit.front ? shader->quality(hit.triangle) : SurfaceQuality{};
      view.predicted_error.at(x, y) = quality.error;
      view.heuristic.at(x, y) = quality.heuristic();
      view.reason.at(x, y) = static_cast<std::uint8_t>(quality.reason()) + 1;
    }
  });
  return view;
}

}  // namespace sheen
