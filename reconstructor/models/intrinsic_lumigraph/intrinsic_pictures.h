// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "reconstructor/models/intrinsic_lumigraph/intrinsic_lumigraph_snapshot.h"
#include "reconstructor/models/surface_properties.h"

namespace sheen {

/// The intrinsic images of a lumigraph (001 sec. 4.3 and 4.4) from any eye, in any light: reflectance R, illumination
/// L = ambient + V b.s, both blended as the views' colours are, and the shadow, 1 - V. What a Lambertian surface does
/// not explain is in neither. Where no view near the eye shows a point, R and L are unseen.
class IntrinsicPictures : public Appearance {
 public:
  IntrinsicPictures(std::shared_ptr<const IntrinsicLumigraphSnapshot> model, SurfaceProperty property)
      : model_(std::move(model)), property_(property) {}
  const Mesh& mesh() const override { return model_->mesh(); }
  std::unique_ptr<ViewShader> shader_for(const ViewQuery& query) const override;

 private:
  /// What is blended in place of a view's colours.
  RelitView of_view(const IntrinsicView& view, const LightState& light) const;

  std::shared_ptr<const IntrinsicLumigraphSnapshot> model_;
  SurfaceProperty property_;
};

}  // namespace sheen
