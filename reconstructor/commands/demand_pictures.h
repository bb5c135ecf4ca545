// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <string>
#include <vector>

#include "common/camera/camera.h"
#include "common/geometry/ray_scene.h"
#include "common/image/exr.h"
#include "reconstructor/render/demand_map.h"

namespace sheen {

/// What the scene required (rank, resolution, bytes) as pictures beside those of a model.
class DemandPictures {
 public:
  /// Throws ConfigError where the model has no patches. `model`: what it is called in that message.
  DemandPictures(const ModelSnapshot& snapshot, const std::string& model);

  /// Writes NAME.rank.png, NAME.resolution.png and NAME.bytes.png, dark to bright up to `most`, and adds parts of these
  /// names, with the values, to the file. `hits`: of the camera's pixels, row by row. Throws FileError.
  void add(const std::vector<Hit>& hits, const Camera& camera, const std::string& name, ExrFile& file) const;

  /// The value at the bright end.
  float most(Demand demand) const { return maps_[static_cast<std::size_t>(demand)].most(); }

 private:
  std::vector<SurfaceDemand> triangles_;
  std::array<DemandMap, kDemands.size()> maps_;
};

}  // namespace sheen
