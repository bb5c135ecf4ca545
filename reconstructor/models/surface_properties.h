// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "reconstructor/models/model_snapshot.h"

namespace sheen {

/// What a model may know of a surface point beside its colour.
enum class SurfaceProperty {
  kPlace,         ///< where it is: object frame, metres
  kReflectance,   ///< R of intrinsic images (001 sec. 4.3), linear RGB
  kIllumination,  ///< L: in the queried light a matt surface has radiance R L
  kShadow,        ///< part of the queried light that does not arrive, 0..1, the same in all channels
};

/// What the snapshot of a model says of its surface that is not the mesh's, beside `ModelSnapshot`. One that is none
/// has the mesh as its surface, and tells nothing of light and reflectance apart.
class KnownSurface {
 public:
  virtual ~KnownSurface() = default;
  /// Else it is a plane that pictures lie in.
  virtual bool is_mesh() const = 0;
  /// In place of colours, unseen where it is not known; null where the model knows no such thing. Of a surface that is
  /// the mesh, nobody asks for the place.
  virtual std::shared_ptr<const Appearance> property(SurfaceProperty property) const = 0;
};

}  // namespace sheen
