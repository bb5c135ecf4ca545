// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/light_field_file/file_layout.h"

#include "common/base/format.h"
#include "reconstructor/coding/powers.h"
#include "reconstructor/light_field_file/grid_geometry.h"
#include "reconstructor/light_field_file/lattice_spectrum.h"

namespace sheen {

std::string layer_name(int layer) {
  return format("L%03d", layer);
}

float step_of_patch(float step, std::int8_t quarter_octaves) {
  return static_cast<float>(double{step} * power_of_two(3 * quarter_octaves));
}

FileLayout file_layout(const CompactModel& model, float step, const std::vector<std::int8_t>& patch_steps,
                       const ForEach& for_each) {
  const ViewHaar haar(model.eyes, box_centre(*model.grid));
  const std::size_t patches = model.shapes.patches.size();
  FileLayout layout;
  layout.patches.images.resize(patches);
  layout.patches.tile_sizes.resize(patches);
  layout.patches.haar_parent.resize(patches);
  layout.plans.resize(patches);
  layout.resolutions.resize(patches);
  for (const std::int8_t patch_step : patch_steps) layout.steps.push_back(step_of_patch(step, patch_step));
  for_each(patches, [&](std::size_t t) {
    const std::vector<std::uint16_t> images = patch_images(model, model.shapes.patches[t]);
    layout.plans[t] = haar.plan(images);
    layout.patches.images[t] = images.size();
    layout.patches.haar_parent[t].resize(images.size());
    for (const ViewHaar::Plan::Step& merge : layout.plans[t].steps)
      layout.patches.haar_parent[t][static_cast<std::size_t>(merge.coefficient)] =
          static_cast<std::uint16_t>(merge.parent);
    for (const std::uint32_t triangle : model.shapes.patches[t].triangles) {
      layout.resolutions[t].push_back(model.maps->resolution(triangle));
      for (const LatticeSpectrum::Tile& tile : lattice_spectrum(layout.resolutions[t].back()).tiles)
        layout.patches.tile_sizes[t].push_back(static_cast<int>(tile.samples.size()));
    }
  });
  return layout;
}

}  // namespace sheen
