// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <span>
#include <string>

#include "common/geometry/mesh.h"
#include "common/geometry/similarity.h"
#include "common/registration/registration_image.h"

namespace sheen {

/// A mesh in another frame than the images' poses, by a mistake of which there are few: its axes are those of another
/// program, its unit is another, or what was applied to the poses was not applied to it.
struct FrameMistake {
  std::string remedy;          ///< what brings the mesh into the poses' frame, a clause in the imperative
  Similarity poses_from_mesh;  ///< the same
  bool mirrored = false;       ///< x of the mesh is negated first; a placement cannot do that
};
/// A clause that says so, with the remedy.
std::string in_words(const FrameMistake& mistake);

/// The mistake that explains how the images see the mesh: with it undone, the outlines of masks or, without them, the
/// surface's texture fit, and as the mesh is they do not. Empty where none does. Tried are all turns by right angles
/// about the origin and about the mesh's middle, with either handedness, common units, and `applied`, what a
/// reconstruction applied to its poses afterwards, either way. `images`: some of which look at the object from about
/// the same side.
std::optional<FrameMistake> find_frame_mistake(const Mesh& mesh, std::span<const RegistrationImage> images,
                                               const std::optional<Similarity>& applied = {});

}  // namespace sheen
