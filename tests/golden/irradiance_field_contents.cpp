// SPDX-License-Identifier: Apache-2.0
#include "common/parallel/for_each.h"
#include "reconstructor/irradiance_field_file/field_lights.h"
#include "reconstructor/irradiance_field_file/field_reader.h"
#include "reconstructor/irradiance_field_file/relighting.h"
#include "tests/golden/contents.h"

namespace sheen {
namespace {

std::vector<FileContents::Part> whole_numbers(const QuantisedField& field) {
  std::vector<FileContents::Part> parts;
  for (const QuantisedField::Component& component : field.components) {
    Checksum basis, maps;
    basis.add_all(component.bits);
    basis.add_all(component.basis);
    maps.add_all(component.coefs);
    parts.push_back(basis.part("basis"));
    parts.push_back(maps.part("maps"));
  }
  return parts;
}

/// A light where an image was taken, and lights between and beyond them.
std::vector<LightState> lights_to_see(const LitScene& scene) {
  const Eigen::Vector3d first = scene.lights.col(0), last = scene.lights.rightCols(1), middle = (first + last) / 2;
  std::vector<LightState> lights;
  for (const Eigen::Vector3d& place : {first, middle, Eigen::Vector3d(2 * last - first)})
    lights.push_back({.kind = scene.kind, .position = place});
  return lights;
}

}  // namespace

FileContents contents_of_irradiance_field(std::string_view bytes, const std::string& file) {
  constexpr std::size_t kApart = 17;
  const StoredField stored = read_field(bytes, file);
  FileContents contents{.whole_numbers = whole_numbers(stored.field)};
  const FieldLights lights(stored.scene);
  const Relighting relighting(dequantise(stored.field), one_after_the_other);
  for (const LightState& light : lights_to_see(stored.scene)) {
    const ImageF picture = relighting.encoded_picture(lights.weights(lights.known(light)), one_after_the_other);
    auto& values = contents.pictures.emplace_back();
    for (std::size_t i = 0; i < picture.size(); i += kApart) values.push_back(value_of_255(picture.data()[i]));
  }
  return contents;
}

}  // namespace sheen
