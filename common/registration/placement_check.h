// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>
#include <string>

#include "common/geometry/mesh.h"
#include "common/registration/registration_image.h"

namespace sheen {

/// Images that are enough for `placement_warning`.
inline constexpr std::size_t kImagesToCheck = 3;

/// Whether a mesh stands where images show the object: a sentence with what to do; empty where nothing speaks against
/// it. By the outlines of masks where there are any, else by whether the images agree better about a mesh that is moved
/// a little. `on_stage`: the poses come from a stage, whose plane is z = 0.
std::string placement_warning(const Mesh& mesh, std::span<const RegistrationImage> images, bool on_stage);

}  // namespace sheen
