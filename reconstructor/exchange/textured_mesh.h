// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <vector>

#include "common/geometry/mesh.h"
#include "common/image/image.h"
#include "reconstructor/models/model_snapshot.h"

namespace sheen {

/// A mesh with one picture of how it looks, as other programs have it: the same from everywhere.
struct TexturedMesh {
  Mesh mesh;                             ///< a vertex for each chart that it is in
  std::vector<Eigen::Vector3f> normals;  ///< unit, per vertex: smooth over the charts' borders
  std::vector<Eigen::Vector2f> place;    ///< per vertex, in the picture: 0..1 from its upper left corner
  ImageU8 picture;                       ///< square, sRGB; what no chart covers has the mean colour
};

/// With about as many texels as the look has samples, at most `most_side`^2. Throws ConfigError where the mesh does not
/// fit (`texture_atlas`).
TexturedMesh textured_mesh(const Mesh& mesh, const AverageLook& look, int most_side);

}  // namespace sheen
