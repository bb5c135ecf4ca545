// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <nlohmann/json_fwd.hpp>
#include <string>

#include "common/geometry/mesh.h"
#include "reconstructor/capture/capture_set.h"

namespace sheen {

/// What `build` may do to the mesh and the poses that it is given.
enum class Refining {
  kWhereItGains,  ///< the mesh, where a quick look finds that it and the images of a data set disagree
  kMesh,
  kMeshAndPoses,
  kNever,
};
/// Of --refine, empty where it is not given, and --no-refine. Throws ConfigError where it is neither mesh nor poses.
Refining refining_of(const std::string& refine, bool no_refine);

/// What a model is built on, and what was found about what was given.
struct ChosenMesh {
  Mesh mesh;
  std::shared_ptr<const Mesh> given;  ///< whose pixels count; null where `mesh` is the given one
  CaptureSet captures;                ///< in the poses to build with
  bool poses_refined = false;         ///< those are not the data set's
  std::string doubt;                  ///< why the given mesh may not be of what the images show; empty: nothing says so
};

/// Looks whether mesh and images fit together, says on standard error where they do not, and refines. A judgement by
/// images that are left out decides whether what was refined is kept. A session is refined only where it is asked for:
/// `build` makes of it what `serve` has shown. `name`: of the mesh, for messages. `report`: what was found.
ChosenMesh choose_mesh(Mesh given, const std::string& name, const std::string& dataset, CaptureSet captures,
                       int hold_out_every, Refining refining, nlohmann::json& report);

}  // namespace sheen
