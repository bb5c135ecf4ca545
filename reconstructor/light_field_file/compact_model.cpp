// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/light_field_file/compact_model.h"

#include <algorithm>
#include <cmath>

#include "reconstructor/light_field_file/grid_geometry.h"

namespace sheen {

float brightest_drawn(const CompactModel& model) {
  constexpr float kBeyond = 1.1f, kWhite = 255;
  return kBeyond * model.brightest / kWhite;
}

PackedColumns<float> packed_terms(const Eigen::MatrixXf& columns, const Eigen::VectorXf& grey_levels) {
  constexpr float kOff = 0.02f;
  const float most = kOff * std::sqrt(12.0f) * 127;  // a step is off by its twelfth's root
  Eigen::Index fine = columns.cols();
  while (fine > 0 && columns.col(fine - 1).cwiseAbs().maxCoeff() * grey_levels[fine - 1] < most) --fine;
  return PackedColumns<float>::fixed_point(columns, fine);
}

Eigen::Vector3f camera_direction(const CompactModel& model, std::size_t vertex, std::size_t camera) {
  return unit_direction(model.grid->points[vertex], model.eyes[camera]);
}

void find_sources(CompactModel& model) {
  std::vector<std::uint8_t> seen;
  for (const CompactVertex& vertex : model.vertices) seen.push_back(vertex.seen);
  model.source = nearest_seen(model.grid->points, model.grid->triangles, seen);
}

std::vector<std::uint16_t> patch_images(const CompactModel& model, const PatchShape& shape) {
  std::vector<std::uint16_t> images;
  for (const std::uint32_t v : shape.vertices)
    if (const CompactVertex* vertex = model.drawn_by(v))
      for (const CompactView& view : vertex->views) images.push_back(view.image);
  std::sort(images.begin(), images.end());
  images.erase(std::unique(images.begin(), images.end()), images.end());
  return images;
}

std::vector<Eigen::Index> places(const CompactVertex& vertex, const std::vector<std::uint16_t>& images) {
  std::vector<Eigen::Index> places;
  places.reserve(vertex.views.size());
  for (const CompactView& view : vertex.views)
    places.push_back(std::lower_bound(images.begin(), images.end(), view.image) - images.begin());
  return places;
}

KrigingSystem kriging_system(const CompactModel& model, const CompactVertex& vertex, const Eigen::Vector3f& normal) {
  KrigingSystem system;
  const auto views = static_cast<Eigen::Index>(vertex.views.size());
  system.directions.resize(3, views);
  system.reliability.resize(views);
  system.kernel = model.kernels[vertex.kernel];
  for (Eigen::Index j = 0; j < views; ++j) {
    const CompactView& view = vertex.views[static_cast<std::size_t>(j)];
    system.directions.col(j) = view.direction;
    system.reliability[j] = view.reliability;
  }
  if (vertex.drift && model.reflection) system.drift = model.reflection->at_each(system.directions, normal);
  return system;
}

}  // namespace sheen
