// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/light_field_file/encode/canonical_mesh.h"

#include <algorithm>
#include <cmath>

namespace sheen {
namespace {

constexpr float kMostSteps = 65535;

}  // namespace

CanonicalMesh canonical_mesh(const Mesh& mesh) {
  Eigen::Array3f low = Eigen::Array3f::Constant(INFINITY), high = -low;
  for (const Triangle& triangle : mesh.triangles)
    for (const std::uint32_t v : triangle) {
      low = low.min(mesh.vertices[v].array());
      high = high.max(mesh.vertices[v].array());
    }
  GridMesh grid{
      .origin = low, .step = std::max((high - low).maxCoeff() / kMostSteps, 1e-30f), .triangles = mesh.triangles};
  grid.points.resize(mesh.vertices.size());
  for (const Triangle& triangle : mesh.triangles)
    for (const std::uint32_t v : triangle) {
      const Eigen::Vector3f at = (mesh.vertices[v] - grid.origin) / grid.step;
      for (int axis = 0; axis < 3; ++axis)
        grid.points[v][static_cast<std::size_t>(axis)] = static_cast<std::int32_t>(std::lround(at[axis]));
    }
  CanonicalMesh canonical{encode_mesh(grid)};
  Mesh coded = canonical.grid.mesh();
  coded.origin = mesh.origin;
  canonical.mesh = std::make_shared<Mesh>(std::move(coded));
  return canonical;
}

}  // namespace sheen
