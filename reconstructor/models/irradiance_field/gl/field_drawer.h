// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "reconstructor/models/irradiance_field/irradiance_field_snapshot.h"
#include "reconstructor/render/gl/model_drawer.h"
#include "reconstructor/render/gl/textured_panel.h"

namespace sheen {

/// Draws an irradiance field. Its camera stands still, so what the mouse moves is the light: the picture fills the
/// panel.
class FieldDrawer : public ModelDrawer {
 public:
  bool update(const std::shared_ptr<const ModelSnapshot>& snapshot) override;
  void draw(const Viewpoint& viewpoint, const DrawArea& area, SurfaceShading shading) override;
  bool follows_eye() const override { return false; }

 private:
  void relight(const Eigen::Vector3d& from);

  TexturedPanel picture_;
  std::shared_ptr<const IrradianceFieldSnapshot> shown_;
  Eigen::Vector3d lit_from_ = Eigen::Vector3d::Zero();  ///< what the picture shows; zero: nothing
};

}  // namespace sheen
