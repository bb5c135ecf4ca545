// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "common/camera/posed_camera.h"
#include "common/geometry/mesh.h"
#include "common/image/image.h"

namespace sheen {

// How 001 sec. 4.5 predicts shadows in lights between, for comparison: an intrinsic lumigraph has a hull in space
// instead (`ShadowHull`).

/// The surface that a view's depth map tells of (z in camera coordinates, metres; 0: none), torn where neighbouring
/// pixels are further apart than a surface that faces the camera can be. What lies behind is not there.
Mesh depth_surface(const PosedCamera& from, const ImageF& depth);

/// Shadows in a row of lights, from one captured light to the next, of one view: one per light. Each blob of the
/// geometric shadows is registered to the blob that it becomes, one light after the other, by an affine map: by
/// moments, then by correlation of the blurred masks (Evangelidis and Psarakis 2008) where that converges. What the
/// images' masks have there is moved by the same maps, from both captured lights, and blended. A blob becomes the one
/// that it overlaps most, else the one with the nearest centroid; one that is joined to another, or comes apart, stays
/// as it is for that step. All masks have one size and one channel; 255 is full shadow. `geometric`: in each light of
/// the row, two at least. `first`, `last`: of the images in the captured lights, which are the row's ends.
std::vector<ImageU8> warped_shadows(std::span<const ImageU8> geometric, const ImageU8& first, const ImageU8& last);

}  // namespace sheen
