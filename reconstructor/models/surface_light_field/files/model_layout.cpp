// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/models/surface_light_field/files/model_layout.h"

#include <algorithm>

#include "common/base/format.h"

namespace sheen {

namespace {

/// Names that sort as they are numbered.
std::string numbered(const char* name, int number) {
  return format("%s%02d", name, number);
}

}  // namespace

void ModelLayout::add_patch(std::uint32_t patch, int patch_samples, int rank) {
  patches.push_back({patch, patch_samples, rank, samples});
  samples += static_cast<std::size_t>(patch_samples);
  max_rank = std::max(max_rank, rank);
}

void ModelLayout::add_vertex(int vertex_views) {
  const std::size_t entry = patches.size() - 1;
  const bool first = vertices.empty() || vertices.back().entry != entry;
  vertices.push_back({entry, first ? 0 : vertices.back().vertex + 1, patches.back().rank, vertex_views, views});
  views += static_cast<std::size_t>(vertex_views);
}

AtlasSize atlas_size(std::size_t pixels) {
  const std::size_t width = std::clamp<std::size_t>(pixels, 1, kAtlasWidth);
  return {static_cast<int>(width), static_cast<int>(std::max<std::size_t>(1, (pixels + width - 1) / width))};
}

std::string rank_part(const char* layer, int rank) {
  return numbered((std::string(layer) + ".rank").c_str(), rank);
}

std::vector<std::string> views_channels(int max_rank) {
  std::vector<std::string> names = {"direction.x", "direction.y", "direction.z", "reliability.Y"};
  for (int r = 0; r < max_rank; ++r) names.push_back(numbered("weight.rank", r));
  return names;
}

std::vector<std::string> vertices_channels(int max_rank) {
  // In the order of the alphabet, in which OpenEXR files hold them.
  std::vector<std::string> names;
  for (int i = 0; i < 9; ++i) names.push_back("frame." + std::to_string(i / 3) + std::to_string(i % 3));
  for (int r = 0; r < max_rank; ++r) names.push_back(numbered("mean.rank", r));
  for (int r = 0; r < max_rank; ++r) names.push_back(numbered("reflection.rank", r));
  return names;
}

}  // namespace sheen
