// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/surface/vertex_visibility.h"

#include <tbb/parallel_for.h>

namespace sheen {

std::vector<std::uint8_t> visible_vertices(const Mesh& mesh, const RayScene& scene, const Camera& camera,
                                           const Rigid3& camera_from_object, const ImageU8& mask, float nearer) {
  const Eigen::Vector3f eye = camera_centre(camera_from_object).cast<float>();
  std::vector<std::uint8_t> visible(mesh.vertices.size());
  tbb::parallel_for(std::size_t{0}, visible.size(), [&](std::size_t v) {
    const auto pixel = camera.project(camera_from_object * mesh.vertices[v].cast<double>());
    if (!pixel || !camera.contains(*pixel, 1)) return;
    if (!mask.empty() && mask.at(static_cast<int>(pixel->x() + 0.5), static_cast<int>(pixel->y() + 0.5)) == 0) return;
    visible[v] = !scene.occluded(Ray{eye, mesh.vertices[v] - eye, 0, nearer});
  });
  return visible;
}

}  // namespace sheen
