// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "reconstructor/refinement/normal_sweep.h"

namespace sheen {

/// Where the images agree best about a vertex.
struct SweepMinimum {
  double place = 0;        ///< patch spacings from where the vertex stands
  double information = 0;  ///< 1 / variance of `place`, up to one factor for all vertices
};

/// The lowest energy, between the places by the parabola through three, where `pull` (energy per squared spacing)
/// leads towards `guide`. Empty where it lies at the end of the sweep or fewer than two images saw the vertex.
std::optional<SweepMinimum> sweep_minimum(const NormalSweep::Energy& energy, int images, double guide, double pull);

}  // namespace sheen
