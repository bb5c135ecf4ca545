// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include "common/image/image.h"

namespace sheen::testing {

/// Views of a glossy, patterned ball of 5 cm radius, in closed form: transforms.json, images, masks, and mesh.ply of
/// the ball (320 triangles). Every 8th view is a test view.
struct BallDataset {
  std::filesystem::path folder;
  int views = 16;
  int width = 160, height = 120;

  std::filesystem::path mesh() const { return folder / "mesh.ply"; }
  std::filesystem::path scene() const { return folder / "scene.toml"; }  ///< of a coarse model, which is quick
  void write() const;
};

}  // namespace sheen::testing
