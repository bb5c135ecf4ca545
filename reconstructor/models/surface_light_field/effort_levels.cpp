// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/models/surface_light_field/effort_levels.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "reconstructor/models/surface_light_field/memory_account.h"

namespace sheen {

std::span<const EffortLevel> all_effort_levels() {
  static constexpr std::array<EffortLevel, 6> kLevels{{
      {1, 64, 0},
      {0.8, 64, 0},
      {0.65, 16, 0},
      {0.65, 12, 4.0 / 3},
      {0.5, 12, 4.0 / 3},
      {0.4, 12, 4.0 / 3},
  }};
  return kLevels;
}

SurfaceLightFieldOptions at_effort_level(const SurfaceLightFieldOptions& options, int level) {
  const EffortLevel& r = all_effort_levels()[static_cast<std::size_t>(level)];
  SurfaceLightFieldOptions out = options;
  out.map_scale *= r.map_scale;
  OnlineSvdOptions& factor = out.patch.factor;
  factor.max_rank = std::min(factor.max_rank, r.max_rank);
  if (r.spare > 0)
    factor.internal_rank =
        std::min(options.patch.factor.terms_kept(), static_cast<int>(std::ceil(r.spare * factor.max_rank)));
  return out;
}

std::span<const double> memory_details() {
  static constexpr std::array<double, 2> kDetails{0.1, 0.2};
  return kDetails;
}

std::span<const PatchLimit> memory_steps() {
  static constexpr std::array<PatchLimit, 6> kSteps{
      {{16, 24, 12, 64}, {12, 18, 8, 48}, {8, 12, 6, 32}, {6, 8, 4, 24}, {4, 5, 3, 16}, {2, 3, 2, 16}}};
  return kSteps;
}

int finest_level(const Mesh& mesh, const Capture& first_capture, const SurfaceLightFieldOptions& options, int first,
                 const MemoryLimit& limit) {
  const int last = static_cast<int>(all_effort_levels().size()) - 1;
  int level = first;
  for (; level < last; ++level) {
    SurfaceLightFieldOptions limited = at_effort_level(options, level);
    limited.patch = limited.patch.limited_to(memory_steps().back());
    const MemoryAccount account = largest_account(mesh, first_capture, limited);
    if ((limit.shown ? account : account.unshown()).total() <= limit.bytes) break;
  }
  return level;
}

}  // namespace sheen
