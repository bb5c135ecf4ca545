// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

namespace sheen {

/// What a triangle required of the model: all 0 where no image reached it.
struct SurfaceDemand {
  float rank = 0;        ///< terms of its patch
  float resolution = 0;  ///< samples along a side of its map
  float bytes = 0;       ///< memory of its patch, shared evenly by the patch's triangles
};

/// What a snapshot of patches can say of them, beside `ModelSnapshot`.
class DemandingSurface {
 public:
  virtual ~DemandingSurface() = default;
  virtual std::vector<SurfaceDemand> demand() const = 0;  ///< per triangle
};

}  // namespace sheen
