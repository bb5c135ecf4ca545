// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>

#include "common/geometry/mesh.h"
#include "common/registration/registration_image.h"
#include "tracker/calibration/point_registration.h"

namespace sheen {

/// Four of the images beside each other, with the mesh's outline as it was (red) and as it is registered (green), and
/// crosses where the picked points are (yellow; outliers magenta).
ImageU8 registration_overlay(const Mesh& mesh, std::span<const RegistrationImage> images, const Similarity& before,
                             const Similarity& after, std::span<const RegisteredPoint> points);

}  // namespace sheen
