// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/light_field_file/light_field_file.h"

#include <utility>

#include "reconstructor/light_field_file/edge_blending.h"

namespace sheen {

bool is_light_field_file(std::string_view start) {
  return start.starts_with(kLightFieldFile.magic);
}

/// A patch at a time: all terms at once in floating point would be the largest part of opening it.
CompactModel QuantisedModel::dequantised(const ForEach& for_each) && {
  const EdgeBlending blending(model);
  for_each(patches.size(), [&](std::size_t i) {
    Patch patch = dequantise(patches[i], layout.resolutions[i], layout.plans[i], layout.steps[i]);
    patches[i] = {};
    patch.state = std::move(model.patches[i].state);
    blending.blend_terms(i, patch.basis.exact());
    patch.basis = packed_terms(patch.basis.exact(), Eigen::VectorXf::Ones(patch.basis.cols()));
    model.patches[i] = std::move(patch);
  });
  blending.blend_means(model.patches);
  return std::move(model);
}

QuantisedModel read_light_field(std::string_view bytes, const std::string& file, const ForEach& for_each,
                                const WhileDecoding& show) {
  LightFieldReader reader(file, for_each);
  while (const auto chunk = reader.read_next(bytes)) {
    if (*chunk == "MESH" && show.mesh) show.mesh(reader.read().model);
    if (*chunk == "STAT" && show.smooth) show.smooth(reader.read());
  }
  return std::move(reader).finish();
}

CompactModel decode_light_field(std::string_view bytes, const std::string& file, const ForEach& for_each,
                                const WhileDecoding& show) {
  return read_light_field(bytes, file, for_each, show).dequantised(for_each);
}

}  // namespace sheen
