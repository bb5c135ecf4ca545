// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "common/camera/posed_camera.h"
#include "common/geometry/mesh.h"

namespace sheen {

/// Of the area of a found surface, by what looks at it.
struct SurfaceSight {
  double smooth = 0;      ///< three views or more look straight enough at it, and no depth was found that agrees
  double underneath = 0;  ///< it faces down, and fewer look at it
  double aside = 0;       ///< it faces elsewhere, and fewer look at it
  Eigen::Vector3d faces_aside = Eigen::Vector3d::Zero();  ///< where the last mostly faces, unit; 0: there is none
};

/// Of a mesh with evidence. `up`: unit.
SurfaceSight sight_of(const Mesh& mesh, std::span<const PosedCamera> cameras, const Eigen::Vector3d& up);

}  // namespace sheen
