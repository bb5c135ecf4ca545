// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>

#include "common/capture/capture.h"
#include "common/geometry/mesh.h"
#include "reconstructor/models/memory_account.h"
#include "reconstructor/models/surface_light_field/surface_light_field_options.h"
#include "reconstructor/surface/map_layout.h"

namespace sheen {

/// Mesh, ray scene and ingest; the rest 0. All images are taken to be as large.
MemoryAccount fixed_account(const Mesh& mesh, const MapLayout& maps, const CaptureSize& image);
/// Of all but held-out views and probe once every patch holds all the terms and views that the options allow. An upper
/// bound but for chroma: where images show it as fine as luma, it takes more.
MemoryAccount largest_account(const Mesh& mesh, const Capture& first, const SurfaceLightFieldOptions& options);

/// Bytes from counts alone: `least` with the fewest terms that are any use, `most` with all terms and views that the
/// options allow; both on the smallest maps.
MemoryNeed memory_need(std::size_t triangles, const SurfaceLightFieldOptions& options);

}  // namespace sheen
