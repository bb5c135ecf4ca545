// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>

#include "common/base/progress.h"
#include "common/geometry/mesh.h"
#include "reconstructor/refinement/refinement_images.h"
#include "reconstructor/shape/shape_measures.h"

namespace sheen {

struct ShapeOptions {
  std::size_t triangles = 0;       ///< about so many; 0: as many as the images resolve
  std::size_t most_views = 60;     ///< in which depth is searched, spread round the object
  double object_pixels = 200'000;  ///< of the object's box in a view, about: finer images are made smaller
  const Mesh* from = nullptr;      ///< about what is looked for (`RoughShape`), where somebody has it
};

struct FoundShape {
  Mesh mesh;                       ///< closed, 2-manifold, one piece, with its evidence
  int outlines = 0;                ///< images that bound the object by an outline
  bool coherent = false;           ///< these agree, so that they are believed
  bool stage_unconfirmed = false;  ///< a file told of a stage whose sheet the images do not show
  std::size_t views = 0;           ///< images that depth was searched in
  double depth_share = 0;          ///< of the object's pixels in these: where depth was found and agreed
  double cell = 0;                 ///< of the lattice that it was put together in, metres
  ShapeMeasures measures;
};

/// Finds the shape of what posed images show (docs/decisions/shape.md). Throws Error where they cannot tell one,
/// saying why.
FoundShape find_shape(const RefinementImages& images, const ShapeOptions& options, const StepsDone& progress = {});

}  // namespace sheen
