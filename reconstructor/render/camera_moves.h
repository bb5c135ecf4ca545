// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "common/camera/posed_camera.h"
#include "common/geometry/mesh.h"
#include "common/image/image.h"

namespace sheen {

/// From where a camera looks at what; metres.
struct LookAt {
  Eigen::Vector3d eye, target;
  Eigen::Vector3d up = Eigen::Vector3d::UnitZ();  ///< of the picture, about
};

/// Whether a picture's axes follow from it: it looks somewhere, and not along its up direction.
bool is_a_view(const LookAt& view);

/// Once round the object, about `first.up` through `first.target`: with so many equal steps back to the first one.
std::vector<LookAt> turntable(const LookAt& first, int frames);

/// A figure of eight that begins at `first` and comes back to it: 30 degrees to each side, 12 up and down. It stays
/// where highlights move, and near where photographs are from.
std::vector<LookAt> swing(const LookAt& first, int frames);

/// Smoothly through given ones (Catmull-Rom), with as many steps from each to the next. `closed`: on from the last one
/// to the first; else the first and the last frame are those given. frames >= 2, keys >= 2.
std::vector<LookAt> through(std::span<const LookAt> keys, int frames, bool closed);

/// Pinholes of one size and focal length at these places: such that each shows all of the object, as large as can be.
std::vector<PosedCamera> framed(std::span<const LookAt> views, const Mesh& mesh, const ImageSize& size);
/// With a vertical field of view of so many degrees instead.
std::vector<PosedCamera> with_field(std::span<const LookAt> views, double degrees, const ImageSize& size);

}  // namespace sheen
