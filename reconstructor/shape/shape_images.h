// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Geometry>
#include <cstddef>
#include <optional>
#include <vector>

#include "reconstructor/refinement/refinement_images.h"
#include "reconstructor/shape/outline_evidence.h"
#include "reconstructor/shape/rough_shape.h"
#include "reconstructor/shape/shape_view.h"
#include "reconstructor/shape/stage_outline.h"
#include "reconstructor/shape/stage_picture.h"

namespace sheen {

/// The images that a shape is found from, as they are read again and again.
struct ShapeImages {
  const RefinementImages& all;
  std::vector<std::size_t> used;             ///< numbers of those
  std::vector<PosedCamera> cameras;          ///< of the used ones
  std::vector<PlainBackground> backgrounds;  ///< likewise; `coarse_views` fills it
  std::vector<bool> cut;                     ///< likewise: the object's outline runs along the rim of the image
  StagePicture sheet;                        ///< likewise: that the object stands on; empty where none is known
  std::vector<SheetSeen> sheets;             ///< likewise
  bool before_sheet = false;                 ///< likewise: outlines are found by it

  std::optional<RoughShape> rough;  ///< that somebody gave

  /// `most` of them, spread round a place. `rough`: null where none was given.
  ShapeImages(const RefinementImages& images, const Eigen::Vector3d& place, std::size_t most, const Mesh* rough);
  Capture read(std::size_t i) const { return all.read(used[i]); }
};

/// Whole images, small, and what their backgrounds look like.
std::vector<ShapeView> coarse_views(ShapeImages& images);

/// Parts of the images round the object, at a scale at which its box has about so many pixels.
std::vector<ShapeView> fine_views(const ShapeImages& images, const Eigen::AlignedBox3d& box, double pixels);

}  // namespace sheen
