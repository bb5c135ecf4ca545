// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>

#include "reconstructor/models/surface_light_field/compact/compact_light_field.h"
#include "reconstructor/models/surface_light_field/snapshot.h"

namespace sheen {

/// The light field in as few bytes as lose so much, or with as little loss as so many bytes allow. Where nobody judges
/// its pictures, what it loses is measured from places between its cameras, against the light field itself. Of the
/// snapshot nothing is kept.
std::unique_ptr<Compression> compress(const SurfaceLightFieldSnapshot& snapshot, CompressionTarget target);

}  // namespace sheen
