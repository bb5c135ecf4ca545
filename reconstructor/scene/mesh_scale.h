// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "common/camera/posed_camera.h"
#include "common/capture/capture.h"
#include "common/geometry/mesh.h"

namespace sheen {

/// "100 x 80 x 52 mm", or in metres where it is larger than one.
std::string size_text(const Mesh& mesh);

/// Whether mesh and cameras, in the frame of the mesh's file, can be of one frame and one unit: a camera fits that
/// stands outside the mesh, has some of it in its image, and larger than a few pixels.
struct MeshScale {
  double fitting = 1;            ///< fraction of the cameras that fit the mesh as it is
  std::optional<double> remedy;  ///< nearly all would fit a mesh scaled by this, and hardly any does as it is
  std::string finding;           ///< a sentence with the sizes and what to do; empty when most cameras fit
};
MeshScale judge_scale(const Mesh& mesh, std::span<const PosedCamera> cameras);

/// Tells on standard error what is doubtful. Throws FileError naming the mesh where it can only be of another unit.
void check_scale(const std::string& mesh_file, const Mesh& mesh, std::span<const PosedCamera> cameras);

/// Watches a capture that is coming in: once its first keyframes are there, it says what `judge_scale` finds.
class ScaleWatch {
 public:
  /// `mesh` must outlive it.
  explicit ScaleWatch(const Mesh& mesh) : mesh_(mesh) {}
  /// The finding, once; else empty.
  std::string look(const Capture& capture);

 private:
  const Mesh& mesh_;
  std::vector<PosedCamera> cameras_;
  bool judged_ = false;
};

}  // namespace sheen
