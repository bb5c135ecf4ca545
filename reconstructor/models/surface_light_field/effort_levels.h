// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>

#include "common/capture/capture.h"
#include "common/geometry/mesh.h"
#include "reconstructor/models/surface_light_field/surface_light_field_options.h"

namespace sheen {

/// A rung of the ladder from the given settings to the quickest ones.
struct Rung {
  double map_scale;  ///< of the side of surface maps
  int max_rank;      ///< terms displayed, at most
  double spare;      ///< terms kept inside for each of these, at most; 0 = as asked
};
/// None asks for more than the one before. What each saves and loses depends on the scene (docs/decisions/budget.md).
std::span<const Rung> effort_ladder();
/// The options with a rung's limits laid on them.
SurfaceLightFieldOptions at_rung(const SurfaceLightFieldOptions& options, int rung);

/// What rings are cut down to, step by step, when they outgrow the memory that they may take.
struct TermLimit {
  int max_rank, internal_rank, block;  ///< as in RingFactorOptions
};
std::span<const TermLimit> memory_steps();
/// The rung, `first` or a coarser one, with the finest maps of which the memory can hold eight terms (as many as there
/// are where the options allow fewer) whatever images come, held-out views apart; the last one when it can of none.
int finest_rung(const Mesh& mesh, const Capture& first_capture, const SurfaceLightFieldOptions& options, int first,
                double bytes);

}  // namespace sheen
