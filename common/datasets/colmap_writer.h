// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <filesystem>
#include <span>
#include <vector>

#include "common/datasets/dataset.h"

namespace sheen {

/// A point of the surface, in the frame of the poses (metres), and its colour (sRGB).
struct ColouredPoint {
  Eigen::Vector3d position = Eigen::Vector3d::Zero();
  std::array<std::uint8_t, 3> colour{};
};

/// A COLMAP model of these views, as text and as binary (the same numbers): `cameras`, `images` and `points3D`, no
/// observations; equal cameras are one. Where views are held out, or all of them say that they are for training,
/// `test.txt` has the names of those held out, a line each, as Gaussian splatting's trainers read it. Lights have no
/// place in it. `folder` must exist. Throws FileError, also for a name that a line of the text cannot hold.
void write_colmap(const std::filesystem::path& folder, const std::vector<DatasetView>& views,
                  std::span<const ColouredPoint> points);

}  // namespace sheen
