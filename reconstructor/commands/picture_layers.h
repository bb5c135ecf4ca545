// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <memory>
#include <string>
#include <vector>

#include "common/base/command_line.h"
#include "common/camera/posed_camera.h"
#include "common/capture/lighting.h"
#include "common/image/exr.h"
#include "reconstructor/models/surface_properties.h"
#include "reconstructor/render/ray_painter.h"

namespace sheen {

/// What a picture's EXR can hold beside its colours: depth, normals, reflectance, illumination, shadow.
ValueCheck is_layer();

/// Layers of the pictures of a model, as parts of their EXR files: of what the rays through the pixels' centres meet.
class PictureLayers {
 public:
  /// `names`: as `is_layer` has them. `model`: what it is called in messages. Throws ConfigError for a layer that the
  /// model does not have.
  PictureLayers(const std::vector<std::string>& names, std::shared_ptr<const ModelSnapshot> snapshot,
                const std::string& model);

  /// Adds a part for each; where there is no surface, depth is infinite and all else 0. `painter`: of the model's mesh.
  void add(const RayPainter& painter, const PosedCamera& from, const LightState& light, ExrFile& file) const;

 private:
  std::shared_ptr<const ModelSnapshot> snapshot_;
  bool depth_ = false;
  std::vector<Eigen::Vector3f> normals_;      ///< of the vertices; empty where nobody asks for them
  std::shared_ptr<const Appearance> places_;  ///< of a surface that is not the mesh
  struct Property {
    std::string name;
    std::vector<std::string> channels;
    std::shared_ptr<const Appearance> appearance;
  };
  std::vector<Property> properties_;
};

}  // namespace sheen
