// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>

#include "common/capture/capture.h"
#include "common/geometry/mesh.h"
#include "reconstructor/models/memory_account.h"
#include "reconstructor/models/surface_light_field/surface_light_field_options.h"

namespace sheen {

/// What an effort level makes of the given settings.
struct EffortLevel {
  double map_scale;  ///< of the side of surface maps
  int max_rank;      ///< terms displayed, at most
  double spare;      ///< terms kept inside for each of these, at most; 0 = as asked
};
/// From the given settings (level 0) to the quickest ones; none asks for more than the one before. What each saves and
/// loses depends on the scene (docs/decisions/budget.md).
std::span<const EffortLevel> all_effort_levels();
/// The options with an effort level's limits laid on them.
SurfaceLightFieldOptions at_effort_level(const SurfaceLightFieldOptions& options, int level);

/// `SurfaceLightFieldOptions::map_detail`, step by step, when patches outgrow the memory that they may take: maps
/// become coarser where that shows least.
std::span<const double> memory_details();
/// What patches are cut down to, step by step, when that is not enough.
std::span<const PatchLimit> memory_steps();
/// The effort level, `first` or a coarser one, with the finest maps of which the memory can hold the fewest terms and
/// views that patches are ever cut down to, whatever images come, held-out views apart; the last one when it can of
/// none.
int finest_level(const Mesh& mesh, const Capture& first_capture, const SurfaceLightFieldOptions& options, int first,
                 const MemoryLimit& limit);

}  // namespace sheen
