// SPDX-License-Identifier: Apache-2.0
#include "reconstructor/commands/demand_pictures.h"

#include <cmath>
#include <utility>

#include "common/base/errors.h"
#include "common/image/image_io.h"

namespace sheen {

DemandPictures::DemandPictures(const ModelSnapshot& snapshot, const std::string& model)
    : triangles_(surface_demand(snapshot)),
      maps_{DemandMap(snapshot, kDemands[0]), DemandMap(snapshot, kDemands[1]), DemandMap(snapshot, kDemands[2])} {
  if (triangles_.empty()) throw ConfigError(model + ": --demand is of models with patches, surface light fields");
}

void DemandPictures::add(const std::vector<Hit>& hits, const Camera& camera, const std::string& name,
                         ExrFile& file) const {
  for (std::size_t d = 0; d < kDemands.size(); ++d) {
    ImageU8 picture(camera.width, camera.height, 3);
    ImageF values(camera.width, camera.height, 1);
    for (std::size_t i = 0; i < hits.size(); ++i) {
      if (!hits[i]) continue;
      const float level = maps_[d].levels()[hits[i].triangle];
      if (level < 0) continue;  // black, as where there is no surface: no image asked for anything
      const Eigen::Vector3f colour = demand_colour(level);
      for (int c = 0; c < 3; ++c)
        picture.data()[3 * i + static_cast<std::size_t>(c)] = static_cast<std::uint8_t>(std::lround(255 * colour[c]));
      values.data()[i] = value_of(triangles_[hits[i].triangle], kDemands[d]);
    }
    write_png(name + "." + to_string(kDemands[d]) + ".png", picture);
    file.parts.push_back({to_string(kDemands[d]), {"Y"}, std::move(values), ExrPrecision::kFloat});
  }
}

}  // namespace sheen
