// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "common/geometry/mesh.h"
#include "common/geometry/similarity.h"
#include "common/registration/registration_image.h"

namespace sheen {

/// Images that are enough for `placement_warning`.
inline constexpr std::size_t kImagesToCheck = 3;

/// What is known of where a mesh should stand, beside the images.
struct PlacementFacts {
  bool on_stage = false;              ///< the poses come from a stage, whose plane is z = 0
  std::optional<Similarity> applied;  ///< what a reconstruction applied to its poses afterwards
  /// More images, from other sides too: asked for only where something speaks against the mesh. Empty: there are none.
  std::function<std::vector<RegistrationImage>()> more;
};

struct PlacementWarning {
  std::string text;        ///< a sentence with what to do; empty: nothing speaks against the mesh
  bool explained = false;  ///< by a mistake of frames, which is named
};

/// Whether a mesh stands where images show the object. By the outlines of masks where there are any, else by whether
/// the images agree better about a mesh that is moved a little. Where it does not, a mistake of frames may explain it
/// (`find_frame_mistake`).
PlacementWarning placement_warning(const Mesh& mesh, std::span<const RegistrationImage> images,
                                   const PlacementFacts& facts = {});

}  // namespace sheen
