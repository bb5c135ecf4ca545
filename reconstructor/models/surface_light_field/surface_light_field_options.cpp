// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/models/surface_light_field/surface_light_field_options.h"

#include <string>

#include "common/base/errors.h"

namespace sheen {

void require_valid(const SurfaceLightFieldOptions& options) {
  const auto require = [](bool holds, const char* rule) {
    if (!holds) throw ConfigError(std::string("surface light field: ") + rule);
  };
  require(options.surface_map == 0 || (options.surface_map >= 2 && options.surface_map <= 64),
          "surface_map must be 0 (chosen from the footprint) or 2..64");
  require(options.map_scale >= 0.05 && options.map_scale <= 4, "map_scale must be in [0.05, 4]");
  require(options.ring.repeat_angle >= 0 && options.ring.repeat_angle < 0.5, "repeat_angle must be in [0, 0.5) rad");
  require(options.hold_out_every >= 0 && options.hold_out_every != 1,
          "hold_out_every must be 0 (none) or at least 2: with 1 nothing would be left to learn from");
  require(options.ring.factor.max_rank >= 1 && options.ring.factor.max_rank <= 64, "max_rank must be 1..64");
  require(
      options.ring.factor.internal_rank == 0 || (options.ring.factor.internal_rank >= options.ring.factor.max_rank &&
                                                 options.ring.factor.internal_rank <= 64),
      "internal_rank must be 0 (chosen from max_rank) or max_rank..64");
  require(options.ring.factor.block >= 1 && options.ring.factor.block <= 32, "block must be 1..32");
  require(options.ring.factor.tolerance >= 0 && options.ring.factor.tolerance < 1, "tolerance must be in [0, 1)");
  require(options.ring.min_visible >= 0 && options.ring.min_visible <= 1, "min_visible must be in [0, 1]");
  require(options.ring.max_views >= 8 && options.ring.max_views <= 1000, "max_views must be 8..1000");
  require(options.visibility.erosion_px >= 0 && options.visibility.erosion_px <= 32, "erosion_px must be 0..32");
}

}  // namespace sheen
