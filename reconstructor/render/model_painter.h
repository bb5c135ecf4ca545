// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "common/camera/posed_camera.h"
#include "common/capture/lighting.h"
#include "reconstructor/models/model_snapshot.h"
#include "reconstructor/render/outlines.h"
#include "reconstructor/render/ray_painter.h"

namespace sheen {

/// A model as it is seen from given places in the frame of its mesh's file, in which cameras and lights are told here.
/// The model must outlive it. Thread-safe.
class ModelPainter {
 public:
  explicit ModelPainter(const ModelSnapshot& model) : model_(model), rays_(model.mesh()), outlines_(model.mesh()) {}

  const RayPainter& rays() const { return rays_; }
  /// In the object frame.
  PosedCamera place_of(const PosedCamera& camera) const;
  /// Likewise; fixed for a model that does not know moving light.
  LightState light_of(const LightState& light) const;
  SmoothView paint(const PosedCamera& camera, const LightState& light) const;

 private:
  const ModelSnapshot& model_;
  RayPainter rays_;
  Outlines outlines_;
};

}  // namespace sheen
