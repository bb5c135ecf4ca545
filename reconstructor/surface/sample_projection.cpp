// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/surface/sample_projection.h"

#include "common/camera/batch_projection.h"

namespace sheen {

SampleProjection::SampleProjection(const Mesh& mesh, const MapLayout& maps) : mesh_(mesh) {
  use(maps);
}

void SampleProjection::use(const MapLayout& maps) {
  maps_ = &maps;
  for (std::size_t t = 0; t < maps.triangles(); ++t) {
    const int n = maps.resolution(t);
    Lattice& lattice = lattices_[static_cast<std::size_t>(n)];
    if (!lattice.u.empty()) continue;
    for (int i = 0; i < n; ++i)
      for (int j = 0; i + j < n; ++j) {
        lattice.u.push_back(static_cast<float>(i) / static_cast<float>(n - 1));
        lattice.v.push_back(static_cast<float>(j) / static_cast<float>(n - 1));
      }
  }
}

void SampleProjection::use(const Camera& camera, const Rigid3& camera_from_object) {
  camera_ = camera;
  camera_from_object_ = camera_from_object;
}

SampleProjection::Places SampleProjection::of(std::size_t t) const {
  const Eigen::Vector3d corner = camera_from_object_ * mesh_.corner(t, 0).cast<double>();
  const Eigen::Vector3d along_u = camera_from_object_ * mesh_.corner(t, 1).cast<double>() - corner;
  const Eigen::Vector3d along_v = camera_from_object_ * mesh_.corner(t, 2).cast<double>() - corner;
  const Lattice& lattice = lattices_[static_cast<std::size_t>(maps_->resolution(t))];
  const std::size_t samples = lattice.u.size();
  thread_local std::vector<float> buffer;
  buffer.resize(5 * samples);
  const std::span<float> all(buffer);
  const auto part = [&](std::size_t i) { return all.subspan(i * samples, samples); };
  for (int axis = 0; axis < 3; ++axis) {
    const auto c = static_cast<float>(corner[axis]), du = static_cast<float>(along_u[axis]),
               dv = static_cast<float>(along_v[axis]);
    float* out = part(static_cast<std::size_t>(axis)).data();
    for (std::size_t s = 0; s < samples; ++s) out[s] = c + lattice.u[s] * du + lattice.v[s] * dv;
  }
  project(camera_, part(0), part(1), part(2), part(3), part(4));
  return {part(3), part(4), part(2)};
}

}  // namespace sheen
