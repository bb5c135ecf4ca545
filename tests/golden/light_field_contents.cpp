// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/light_field_file/light_field_evaluator.h"
#include "reconstructor/light_field_file/light_field_file.h"
#include "tests/golden/contents.h"

namespace sheen {
namespace {

void add_map(Checksum& sum, const QuantisedMap& map, std::size_t bands) {
  sum.add(map.empty());
  for (std::size_t b = 0; !map.empty() && b < bands; ++b) sum.add_all(map.band(b));
}

std::vector<FileContents::Part> whole_numbers(const QuantisedModel& quantised) {
  const CompactModel& model = quantised.model;
  Checksum mesh, lattices, eyes, vertices, patches, states;
  for (const Triangle& triangle : model.grid->triangles) mesh.add_all(triangle);
  for (const GridMesh::Point& point : model.grid->points) mesh.add_all(point);
  for (std::size_t t = 0; t < model.maps->triangles(); ++t) lattices.add(model.maps->resolution(t));
  lattices.add_all(model.shapes.patch_of);
  for (const GridMesh::Point& eye : model.eyes) eyes.add_all(eye);
  vertices.add_all(model.source);
  for (const CompactVertex& vertex : model.vertices) {
    for (const std::int64_t number :
         {std::int64_t{vertex.seen}, std::int64_t{vertex.kernel}, std::int64_t{vertex.drift},
          std::int64_t{vertex.views_folded}, static_cast<std::int64_t>(vertex.views.size())})
      vertices.add(number);
    for (const CompactView& view : vertex.views) {
      vertices.add(view.image);
      vertices.add(view.moved);
    }
  }
  for (std::size_t p = 0; p < quantised.patches.size(); ++p) {
    const QuantisedPatch& patch = quantised.patches[p];
    const std::size_t bands = 3 * quantised.layout.patches.tile_sizes[p].size();
    add_map(patches, patch.mean, bands);
    patches.add(static_cast<std::int64_t>(patch.terms.size()));
    for (const QuantisedTerm& term : patch.terms) {
      patches.add_all(term.coefficients);
      patches.add(term.scale);
      add_map(patches, term.map, bands);
    }
    for (const SampleState state : model.patches[p].state) states.add(static_cast<std::int64_t>(state));
  }
  return {mesh.part("mesh"),         lattices.part("lattices"), eyes.part("eyes"),
          vertices.part("vertices"), patches.part("patches"),   states.part("states")};
}

std::vector<std::uint8_t> picture_of_means(const CompactModel& model) {
  constexpr Eigen::Index kApart = 41;  // enough of them
  std::vector<std::uint8_t> means;
  for (const Patch& patch : model.patches)
    for (Eigen::Index i = 0; i < patch.mean.size(); i += kApart) means.push_back(value_of_255(patch.mean[i]));
  return means;
}

/// The middle of some triangles, seen from an eye.
std::vector<std::uint8_t> picture_from(const Eigen::Vector3d& eye, const CompactModel& model,
                                       const LightFieldEvaluator& light_field) {
  constexpr std::size_t kApart = 5;
  constexpr float kMiddle = 1.0f / 3;
  const Eigen::MatrixXf coefficients = light_field.coefficients_for(eye, one_after_the_other);
  std::vector<std::uint8_t> colours;
  for (std::size_t t = 0; t < model.mesh->triangles.size(); t += kApart) {
    const TrianglePlace place = light_field.shapes().place(t);
    const SurfacePatch* patch = light_field.patches()[place.patch].get();
    if (!patch) continue;
    const LatticeStencil stencil = lattice_stencil(model.maps->resolution(t), kMiddle, kMiddle);
    const Eigen::Vector3f encoded =
        patch->colour(place, stencil, coefficients, kMiddle, kMiddle).cwiseMin(brightest_drawn(model));
    for (int c = 0; c < 3; ++c) colours.push_back(value_of_255(255 * encoded[c]));
  }
  return colours;
}

/// Where images were taken, between them, and where none was near.
std::vector<Eigen::Vector3d> eyes(const CompactModel& model) {
  const Eigen::Vector3d first = camera_centre(model.cameras.front().camera_from_object),
                        last = camera_centre(model.cameras.back().camera_from_object);
  return {first, last, (first + last) / 2, -first, {0, 0, 2 * first.norm()}, {0, 0, -2 * first.norm()}};
}

}  // namespace

FileContents contents_of_light_field(std::string_view bytes, const std::string& file) {
  QuantisedModel quantised = read_light_field(bytes, file, one_after_the_other);
  FileContents contents{.whole_numbers = whole_numbers(quantised)};
  CompactModel model = std::move(quantised).dequantised(one_after_the_other);
  contents.pictures.push_back(picture_of_means(model));
  const LightFieldEvaluator light_field(model, one_after_the_other);
  for (const Eigen::Vector3d& eye : eyes(model)) contents.pictures.push_back(picture_from(eye, model, light_field));
  return contents;
}

}  // namespace sheen
