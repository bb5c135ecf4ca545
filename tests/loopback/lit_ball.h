// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

namespace sheen::testing {

/// Pictures of a matt ball on a grey ground, in closed form, by a camera that stands still, each in another far light;
/// without shadows. `dirs.lp` lists them.
struct LitBall {
  std::filesystem::path folder;
  int lights = 24;
  double turn = 0;  ///< of the spiral that the lights are on, radians

  std::filesystem::path list() const { return folder / "dirs.lp"; }
  void write() const;
};

}  // namespace sheen::testing
