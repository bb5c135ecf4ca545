// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "reconstructor/light_field_file/patch_shapes.h"
#include "reconstructor/radiance/resampling.h"
#include "reconstructor/surface/map_layout.h"
#include "reconstructor/surface/sample_visibility.h"

namespace sheen {

/// What one image shows of one patch: a column of its matrix (000 sec. 4.1).
struct PatchColumn {
  Eigen::VectorXf values;             ///< 3 x samples of the patch, encoded (`resample`); meaningless where not visible
  std::vector<std::uint8_t> visible;  ///< per sample of the patch
};

bool shows(const SurfaceView& view, const PatchShape& patch);

/// False when no sample of the patch is visible; `column` is then unchanged. Its buffers are reused.
bool gather(const PatchShape& patch, const SurfaceImage& image, PatchColumn& column);

/// How far to rely on the image at each vertex of the mesh, in (0, 1]: the cosine of the most frontal visible triangle
/// round it, times the fraction of the triangles round it that is visible. Where nothing is, a patch may have a guess:
/// hardly at all.
std::vector<float> reliability_at_vertices(const Mesh& mesh, const MapLayout& maps, const SurfaceView& view);

}  // namespace sheen
