// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "common/camera/camera.h"
#include "common/capture/capture.h"
#include "common/image/image.h"

namespace sheen {

struct RefinerOptions {
  double reach_px = 4;           ///< to either side, where an edge is searched; at most 8
  double reach_cells = 0.7;      ///< and no farther than this part of a tag cell, so that the code stays out
  double min_reach_px = 1.5;     ///< tags too small for that are dropped
  double skipped_ends = 0.08;    ///< of an edge's length, where the neighbouring edge takes part
  double min_contrast = 20;      ///< grey levels between paper and ink
  double max_correction_px = 3;  ///< a corner that moves farther followed something else than its edge
  int rounds = 2;  ///< each starts from the corners of the one before, and reaches no farther than the edge is blurred
};

/// Puts the corners of tags where the edges of their black squares meet, and drops the tags whose edges cannot be
/// measured. At points along each edge the position across it follows from the area between paper's level and the
/// profile, which a symmetric blur (defocus, pixel, interpolation) does not move; the line through them is fitted
/// robustly. Edges are straight in undistorted coordinates only, so lines live there and the image is sampled through
/// the lens.
void refine_corners(const ImageU8& grey, const Camera& camera, std::vector<TagObservation>& tags,
                    const RefinerOptions& options = {});

/// Length (pixels) of the motion streak that lies over the tags' edges, seen in their width: of a box streak of length
/// L across an edge the profile's slope has the variance L^2 / 12 beyond that of a sharp edge. The longest over the
/// directions of the edges, median over the tags. Sudden jerks show here that no motion between frames predicts.
/// Streaks beyond the reach of the profiles (about 5 px) read as that; 0 for sharp edges. Corners must be refined.
double measured_streak_px(const ImageU8& grey, const Camera& camera, const std::vector<TagObservation>& tags,
                          const RefinerOptions& options = {});

}  // namespace sheen
