// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>
#include <utility>

#include "common/geometry/mesh.h"
#include "reconstructor/models/intrinsic_lumigraph/mean_look.h"
#include "reconstructor/models/intrinsic_lumigraph/view_blend.h"

namespace sheen {

/// Colours of a mesh, from what the views round an eye show. Where they show little this fades to the mean look, if
/// that is given, and on the inside of an open object to plain grey.
class SurfaceBlend {
 public:
  SurfaceBlend(std::shared_ptr<const Mesh> mesh, ViewBlend views, std::optional<MeanLook::Lit> elsewhere)
      : mesh_(std::move(mesh)), views_(std::move(views)), elsewhere_(std::move(elsewhere)) {}

  using Sample = MeanLook::Lit::Sample;
  /// At barycentric (u, v) of a triangle's front or back.
  Sample at(std::uint32_t triangle, float u, float v, bool front) const;

 private:
  std::shared_ptr<const Mesh> mesh_;
  ViewBlend views_;
  std::optional<MeanLook::Lit> elsewhere_;
};

}  // namespace sheen
