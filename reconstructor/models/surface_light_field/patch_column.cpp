// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/models/surface_light_field/patch_column.h"

#include <algorithm>

namespace sheen {

bool shows(const SurfaceView& view, const PatchShape& patch) {
  return std::any_of(patch.triangles.begin(), patch.triangles.end(),
                     [&](std::uint32_t t) { return view.visible_in_triangle[t] > 0; });
}

bool gather(const PatchShape& patch, const SurfaceImage& image, PatchColumn& column) {
  if (!shows(image.view, patch)) return false;
  column.visible.resize(patch.samples);
  column.values.resize(3 * Eigen::Index{patch.samples});
  column.values.setZero();
  std::ptrdiff_t to = 0;
  for (const std::uint32_t t : patch.triangles) {
    const int count = lattice_samples(image.maps.resolution(t));
    std::copy_n(image.view.visible.begin() + static_cast<std::ptrdiff_t>(image.maps.first_sample(t)), count,
                column.visible.begin() + to);
    resample(image, t, Eigen::Map<Eigen::Matrix3Xf>(column.values.data() + 3 * to, 3, count));
    to += count;
  }
  return true;
}

std::vector<float> reliability_at_vertices(const Mesh& mesh, const MapLayout& maps, const SurfaceView& view) {
  constexpr float kLeast = 0.003f;
  struct Round {  // the triangles round a vertex
    int samples = 0, visible = 0;
    float cosine = 0;
  };
  std::vector<Round> round(mesh.vertices.size());
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const int visible = view.visible_in_triangle[t];
    for (const std::uint32_t v : mesh.triangles[t]) {
      round[v].samples += lattice_samples(maps.resolution(t));
      round[v].visible += visible;
      if (visible > 0) round[v].cosine = std::max(round[v].cosine, view.cosine[t]);
    }
  }
  std::vector<float> reliability;
  reliability.reserve(round.size());
  for (const Round& r : round)
    reliability.push_back(
        std::max(kLeast, r.cosine * (static_cast<float>(r.visible) / static_cast<float>(std::max(r.samples, 1)))));
  return reliability;
}

}  // namespace sheen
