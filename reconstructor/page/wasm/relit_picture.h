// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "reconstructor/irradiance_field_file/field_lights.h"
#include "reconstructor/irradiance_field_file/relighting.h"

namespace sheen {

/// An irradiance field for a page: its camera's picture in any light.
class RelitPicture {
 public:
  /// `file`: its name in errors. Throws FileError.
  RelitPicture(std::string_view bytes, const std::string& file);

  /// Width and height of the picture; 1 where its lights are places, 0 where they are directions; the mean
  /// of how far they are from the origin; what is right, down and forward to the camera (x y z each), in the frame of
  /// the lights.
  const std::vector<double>& scene() const { return scene_; }
  /// x y z each.
  const std::vector<double>& lights() const { return places_; }

  /// RGBA of the picture in a light at this place, or from this direction.
  const std::vector<std::uint8_t>& in_light(const Eigen::Vector3d& place);
  const std::vector<std::uint8_t>& pixels() const { return pixels_; }  ///< those of the last light

 private:
  std::vector<double> scene_, places_;
  LightKind kind_ = LightKind::kDirectional;
  std::optional<FieldLights> lights_;
  std::optional<Relighting> relighting_;
  std::vector<std::uint8_t> pixels_;
};

}  // namespace sheen
