// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/shape/shape_file.h"

#include <vector>

#include "common/geometry/mesh_io.h"

namespace sheen {

void save_shape(const FoundShape& shape, const std::filesystem::path& path) {
  std::vector<float> values;
  for (const ShapeEvidence kind : shape.evidence) values.push_back(static_cast<float>(kind));
  const VertexValues columns[] = {{.name = "evidence", .values = values, .bytes = true}};
  save_ply(shape.mesh, path, columns);
}

}  // namespace sheen
