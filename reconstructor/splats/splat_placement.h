// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "common/geometry/mesh.h"
#include "reconstructor/models/model_snapshot.h"
#include "reconstructor/splats/splats.h"

namespace sheen {

/// Flat Gaussians that cover a surface, about `count` of them: the surface is divided into as many pieces, each of what
/// is nearest to its middle in place and normal (centroidal Voronoi cells), smaller where the look has detail. Each
/// piece is a Gaussian of its mean and covariance, somewhat wider, so that no gaps are left between them, with the mean
/// of the look as its colour.
Splats place_splats(const Mesh& mesh, const ViewShader& look, std::size_t count, int degree);

/// Of one of so many pieces of a surface: the root of its area, metres.
float mean_width(const Mesh& mesh, std::size_t count);

}  // namespace sheen
