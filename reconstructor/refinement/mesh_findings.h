// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

#include "common/image/image.h"
#include "reconstructor/refinement/mesh_refinement.h"

namespace sheen {

/// The similarity that a mesh was off by, from where its vertices moved: x -> centre + (1 + scale) (x - centre) +
/// offset, turned by `rotation`.
struct MeshOffset {
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();    ///< of the observed vertices, metres
  double scale = 0;                                    ///< of the corrected mesh, less 1
  Eigen::Vector3d offset = Eigen::Vector3d::Zero();    ///< metres
  Eigen::Vector3d rotation = Eigen::Vector3d::Zero();  ///< rotation vector, rad
  double explained = 0;                                ///< fraction of the squares of the moves that it explains
};
/// Robust least squares over the observed vertices.
MeshOffset common_offset(const Mesh& given, const RefinedMesh& refined);

/// A region of an image's mask that lies well away from all that the mesh shows: a part that the mesh has not.
struct UncoveredRegion {
  double pixels = 0;  ///< area; 0: none
  double centre_x = 0, centre_y = 0;
};
/// The largest such region further than `margin_px` from the silhouette. None where the mask is far larger than the
/// silhouette: it then says what may be looked at, not where the object is.
UncoveredRegion uncovered_region(const ImageU8& mask, const ImageU8& silhouette, double margin_px);

/// What is wrong with a mesh as a whole, a sentence each, with what to do; empty for a mesh that is right.
struct MeshFinding {
  std::string kind;  ///< "scale", "offset", "rotation" or "missing part"
  std::string sentence;
};
std::vector<MeshFinding> findings_of(const Mesh& given, const RefinedMesh& refined, const RefinementImages& images);

}  // namespace sheen
