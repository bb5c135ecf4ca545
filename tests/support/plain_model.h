// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <set>

#include "reconstructor/models/model_snapshot.h"

namespace sheen::testing {

/// A model without captures: one radiance everywhere, or the object's places as colours. It must outlive its shaders.
class PlainModel : public Appearance {
 public:
  explicit PlainModel(const Mesh& mesh, Eigen::Vector3f radiance = {1, 1, 1}) : mesh_(mesh), radiance_(radiance) {}

  std::set<std::uint32_t> unseen, imputed;  ///< triangles
  bool shows_place = false;
  mutable Eigen::Vector3d eye = Eigen::Vector3d::Zero();  ///< that was asked for last

  const Mesh& mesh() const override { return mesh_; }
  std::unique_ptr<ViewShader> shader_for(const ViewQuery& query) const override {
    eye = query.eye;
    return std::make_unique<Shader>(*this);
  }

 private:
  class Shader : public ViewShader {
   public:
    explicit Shader(const PlainModel& model) : model_(model) {}
    SurfaceSample shade(std::uint32_t t, float u, float v) const override {
      const Mesh& mesh = model_.mesh_;
      const Eigen::Vector3f place = (1 - u - v) * mesh.corner(t, 0) + u * mesh.corner(t, 1) + v * mesh.corner(t, 2);
      return {model_.shows_place ? place : model_.radiance_, model_.unseen.contains(t)    ? SampleState::kUnseen
                                                             : model_.imputed.contains(t) ? SampleState::kImputed
                                                                                          : SampleState::kMeasured};
    }
    SurfaceQuality quality(std::uint32_t) const override { return {true, 0.05f, 1, 0.2f}; }  // 0.5, oblique

   private:
    const PlainModel& model_;
  };

  const Mesh& mesh_;
  Eigen::Vector3f radiance_;
};

}  // namespace sheen::testing
