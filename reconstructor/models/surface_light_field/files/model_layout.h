// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "common/image/image.h"

namespace sheen {

/// 2: kernels have a shape; a drift. 3: a sill. 4: views a reliability; the cameras. 5: patches in place of rings. 6:
/// how views are interpolated, and no view maps. Earlier versions are refused.
inline constexpr int kModelVersion = 6;
inline constexpr const char* kModelFormat = "sheen surface light field";
inline constexpr const char* kModelIdAttribute = "sheen.model";
inline constexpr const char *kKrigingWord = "kriging", *kDelaunayWord = "delaunay";  ///< `ViewMethod`
inline constexpr const char* kPaperHeuristicWord = "paper-heuristic";                ///< `GuidanceMethod`
inline constexpr const char* kMeshFile = "mesh.ply";
inline constexpr const char* kJsonFile = "model.json";
inline constexpr const char* kMapsFile = "maps.exr";

inline constexpr int kMaxRank = 100;  ///< so that names with two digits stay in order

/// A patch as the files have it: patches stand one after the other in their order.
struct PatchEntry {
  std::uint32_t patch = 0;
  int samples = 0, rank = 0;
  std::size_t first_sample = 0;  ///< pixel of the surface atlas
};

/// A vertex of a patch: those of a patch stand in the order of the mesh's vertices.
struct VertexEntry {
  std::size_t entry = 0;       ///< of its patch
  std::size_t vertex = 0;      ///< of the patch's
  int rank = 0, views = 0;     ///< rank: its patch's
  std::size_t first_view = 0;  ///< pixel of the part "views"
};

/// Where everything stands in maps.exr.
struct ModelLayout {
  std::vector<PatchEntry> patches;
  std::vector<VertexEntry> vertices;  ///< of all patches: pixels of the part "vertices"
  std::size_t samples = 0, views = 0;
  int max_rank = 0;

  void add_patch(std::uint32_t patch, int patch_samples, int rank);
  void add_vertex(int vertex_views);  ///< the next one of the patch that was added last
};

/// Lists of pixels are laid row by row into images of this width.
inline constexpr int kAtlasWidth = 4096;
struct AtlasSize {
  int width, height;
};
/// Of so many pixels; at least one.
AtlasSize atlas_size(std::size_t pixels);

/// "surface.rank07"
std::string rank_part(const char* layer, int rank);
inline constexpr int kViewChannels = 4;  ///< of the part "views", before the weights
/// Channel names of the parts "views" (direction, reliability, a weight per rank) and "vertices" (frame row by row, a
/// mean and a drift per rank).
std::vector<std::string> views_channels(int max_rank);
std::vector<std::string> vertices_channels(int max_rank);

}  // namespace sheen
